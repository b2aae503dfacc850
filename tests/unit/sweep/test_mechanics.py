import numpy as np
import pytest

from magicsim.config import load_preset
from magicsim.deform.press import press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects import parse_object
from magicsim.sweep.mechanics import press_curve, spacing_error
from magicsim.sweep.printability import printability

BALL = parse_object("sphere:radius_mm=4")


def design(*settings: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "mini-magictac", settings)


def test_force_and_stiffness_are_read_off_the_press():
    depths, force = np.array([0.1, 0.5, 1.0]), np.array([0.1, 1.0, 3.0])
    found, stiffness = press_curve(depths, force, relative_error=0.1)
    assert (found.value, found.low, found.high) == pytest.approx((3.0, 2.7, 3.3))
    assert (stiffness.value, stiffness.low, stiffness.high) == pytest.approx((4.0, 3.6, 4.4))


@pytest.mark.slow
def test_error_of_a_force_covers_what_a_finer_lattice_changes():
    block = design("footprint_mm=[12,12]", "lattice.growth=1")
    force, finer = (
        press(block.model_copy(update={"lattice": block.lattice.model_copy(update={"spacing_mm": spacing})}), BALL,
              depth_mm=1.0).force_n[2]
        for spacing in (1.0, 0.5)
    )  # fmt: skip
    error = spacing_error(block, BALL, force)
    assert 0 < error < 0.2
    assert 0.3 * error < abs(finer - force) / force < error


def test_error_of_a_force_shrinks_with_the_spacing():
    errors = []
    for spacing in (2.0, 1.0):
        block = load_preset(
            ElastomerDesign, "design", "uniform-block",
            ("footprint_mm=[12,12]", f"lattice.spacing_mm={spacing}", "lattice.cells_across=0", "lattice.growth=1"),
        )  # fmt: skip
        errors.append(spacing_error(block, BALL, press(block, BALL, depth_mm=1.0).force_n[2]))
    assert 0 < errors[1] < errors[0] < 1


def test_base_design_keeps_every_limit():
    found = printability(design())
    assert (found.value, found.note) == (1.0, "")


def test_broken_limits_are_named():
    found = printability(design("skin_mm=2.0", "cell_mm=1.6"))
    assert found.value == pytest.approx(4 / 6)
    assert "recommended skin 0.5 to 1 mm, here 2" in found.note
    assert "printed cell 0.6 to 1 mm, here 1.4" in found.note


def test_block_without_a_grid_has_no_cells_to_judge():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ())
    assert 0 < printability(block).value <= 1
