from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.errors import ConfigError, OutputError
from magicsim.geometry.design import load_design
from magicsim.geometry.pose import Pose
from magicsim.scenes.scene import TaxelSettings, load_scene
from magicsim.simulation.episode import FrameLabels, SimulatedFrame
from magicsim.simulation.touch_truth import TOUCH_COLUMNS, TouchTruth, touch_columns

DESIGN = load_design("mini-magictac", ["footprint_mm=[8,10]"])
SETTINGS = TaxelSettings(rows=5, columns=4)


@pytest.fixture(scope="module")
def lattice() -> Lattice:
    return build_lattice(DESIGN)


def dented(lattice: Lattice) -> Deformation:
    """A dent at x = 2, y = -3."""
    x, y, z = lattice.nodes_mm.T
    moved = np.zeros_like(lattice.nodes_mm)
    moved[:, 2] = 0.5 * np.exp(-((x - 2) ** 2 + (y + 3) ** 2)) * (1 - z / DESIGN.height_mm)
    pose = Pose(position_mm=np.zeros(3), rotation=np.eye(3))
    return replace(Deformation.rest(lattice), displacements_mm=moved, pose=pose)


def test_untouched_sensor_has_no_force_no_stress_and_unit_stretch(lattice: Lattice):
    truth = TouchTruth.of(DESIGN, lattice, SETTINGS)
    found = touch_columns(truth.fields(Deformation.rest(lattice)), SETTINGS)
    assert set(found) == set(TOUCH_COLUMNS) - {"taxel_traction_mpa"}
    for name, each in found.items():
        assert np.all(np.asarray(each) == (1 if "stretch" in name else 0))


def test_fields_are_largest_where_the_skin_is_dented(lattice: Lattice):
    found = touch_columns(TouchTruth.of(DESIGN, lattice, SETTINGS).fields(dented(lattice)), SETTINGS)
    for name in ("skin_stretch", "skin_von_mises_mpa", "infill_shear"):
        image = np.asarray(found[name])
        assert image.shape == (5, 4)
        assert image.dtype == np.float32
        row, column = np.unravel_index(image.argmax(), image.shape)
        assert row >= 3  # y < 0 is in the lower rows
        assert column >= 2
        assert found[f"max_{name}"] == pytest.approx(image.max(), rel=1e-6)
    assert np.shape(found["taxel_force_n"]) == (20, 3)


def test_only_what_is_asked_for_is_there(lattice: Lattice):
    settings = TaxelSettings(rows=2, columns=3, unit="MPa", skin=False, infill=False)
    found = touch_columns(TouchTruth.of(DESIGN, lattice, settings).fields(dented(lattice)), settings)
    assert set(found) == {"taxel_traction_mpa", "taxel_torque_nmm"}


def test_block_without_infill_has_no_shear_of_it():
    design = load_design("uniform-block", ["footprint_mm=[8,8]"])
    lattice = build_lattice(design)
    found = touch_columns(TouchTruth.of(design, lattice, SETTINGS).fields(Deformation.rest(lattice)), SETTINGS)
    assert "infill_shear" not in found
    assert not SETTINGS.has_infill(design)
    assert SETTINGS.has_infill(DESIGN)


def test_scene_refuses_a_grid_that_is_none():
    with pytest.raises(ConfigError, match=r"output.taxels.rows = 0 .*1"):
        load_scene("pressed", ["output.taxels.rows=0"])
    with pytest.raises(ConfigError, match=r"output.taxels.unit = 'kg'.*'N'.*'MPa'"):
        load_scene("pressed", ["output.taxels.unit='kg'"])


def test_frame_without_fields_says_what_to_set():
    frame = SimulatedFrame(image=np.zeros((1, 1, 3), np.uint8), truth=None, labels=FrameLabels())  # type: ignore[arg-type]
    with pytest.raises(OutputError, match=r"--set output.taxels.rows=16"):
        _ = frame.touch
