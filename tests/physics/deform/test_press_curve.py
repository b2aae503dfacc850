"""Force against depth along one path is that of separate presses, and keeps the contact's symmetry exactly."""

from pathlib import Path

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.path import left_by_mirrors
from magicsim.deform.indentation.press import PressCurve, press, press_curve
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.report.drawing import COLUMNS, write_curve

BLOCK = load_preset(
    ElastomerDesign,
    "design",
    "uniform-block",
    ["footprint_mm=[12,16]", "lattice.spacing_mm=1.5", "lattice.cells_across=0"],
)
BALL = parse_object("sphere:radius_mm=4")
DEPTHS = (0.0, 0.2, 0.4, 0.6)


@pytest.fixture(scope="module")
def curve() -> PressCurve:
    return press_curve(BLOCK, BALL, DEPTHS)


def test_depths_start_from_the_untouched_block_and_end_as_a_press(curve: PressCurve):
    assert curve.depths_mm.tolist() == list(DEPTHS)
    assert curve.forces_n[0].tolist() == [0.0, 0.0, 0.0]
    assert (np.diff(curve.forces_n[:, 2]) > 0).all()
    assert (np.diff(curve.areas_mm2) > 0).all()
    for number in (1, 3):  # without friction the way does not matter
        alone = press(BLOCK, BALL, depth_mm=DEPTHS[number])
        assert curve.points[number].force_n[2] == pytest.approx(alone.force_n[2], rel=0.01)
    assert curve.result.force_n == curve.points[-1].force_n


def test_a_small_ball_on_a_high_block_follows_hertz():
    high = BLOCK.model_copy(update={"core_mm": 10.0, "lattice": BLOCK.lattice.model_copy(update={"cells_across": 5})})
    found = press_curve(high, parse_object("sphere:radius_mm=2"), (0.1, 0.2, 0.3))
    slope = np.polyfit(np.log(found.depths_mm), np.log(found.forces_n[:, 2]), 1)[0]
    assert slope == pytest.approx(1.5, abs=0.15)


@pytest.mark.parametrize(
    ("thing", "friction"),
    [("sphere:radius_mm=4", 0.0), ("box:size_mm=4x5x8", 0.8), ("cone:half_angle_deg=40", 0.8)],
)
def test_what_symmetry_forbids_is_exactly_zero(thing: str, friction: float):
    found = press_curve(BLOCK, parse_object(thing), (0.2, 0.4), friction=friction)
    for place in found.points:
        assert (*place.force_n[:2], *place.torque_nmm) == (0.0,) * 5
        assert place.force_n[2] > 0


def test_what_symmetry_allows_stays():
    tilted = press_curve(BLOCK, parse_object("box:size_mm=4x5x8,pitch_deg=20"), (0.4,)).points[-1]
    assert tilted.force_n[1] == tilted.torque_nmm[0] == tilted.torque_nmm[2] == 0.0
    assert abs(tilted.force_n[0]) > 0.01
    sheared = press(BLOCK, BALL, depth_mm=0.4, shear_mm=(0.2, 0.0), friction=0.8)
    assert [each.shear_mm for each in sheared.history] == [(0.0, 0.0), (0.2, 0.0)]
    assert sheared.history[0].force_n[0] == sheared.force_n[1] == 0.0
    assert sheared.force_n[0] > 0.1


def test_a_body_that_has_left_its_symmetry_keeps_its_force():
    force, torque = np.array([0.3, 1e-9, 5.0]), np.array([1e-9, 2.0, 1e-9])
    found = left_by_mirrors(force, torque, (True, True), 10.0)
    assert found.tolist() == [[0.3, 0.0, 5.0], [0.0, 2.0, 0.0]]


@pytest.mark.parametrize(
    ("depths", "message"),
    [
        ((), "0 depths: 1 to 1000"),
        ((0.2, 0.2), r"depths_mm = 0.2 after 0.2 is not allowed"),
        ((0.1, 50.0), "depth_mm = 50 is not allowed: must be 0 to"),
        ((float("nan"),), "depth_mm = nan"),
    ],
)
def test_depths_that_are_no_path_are_refused(depths: tuple[float, ...], message: str):
    with pytest.raises(ConfigError, match=message):
        press_curve(BLOCK, BALL, depths)


def test_a_depth_that_is_no_number_is_named():
    with pytest.raises(ConfigError, match="depth_mm = None is not allowed: must be 0 to"):
        press(BLOCK, BALL, depth_mm=None)


def test_files_hold_the_curve(curve: PressCurve, tmp_path: Path):
    write_curve(curve, tmp_path / "ball.csv", title="ball")
    rows = np.genfromtxt(tmp_path / "ball.csv", delimiter=",", names=True)
    assert rows.dtype.names == COLUMNS
    np.testing.assert_array_equal(rows["force_z_n"], curve.forces_n[:, 2])
    np.testing.assert_array_equal(rows["depth_mm"], DEPTHS)
    write_curve(curve, tmp_path / "ball.png", title="ball")
    assert (tmp_path / "ball.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ConfigError, match=r"must end in \.csv or \.png"):
        write_curve(curve, tmp_path / "ball.txt", title="ball")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.csv", "ball.png"]
