import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.sweep.mechanics import press_centrally, press_curve, spacing_error
from magicsim.sweep.parts import block_of
from magicsim.sweep.result import printability

BALL = parse_object("sphere:radius_mm=4")


def design(*settings: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "mini-magictac", settings)


def test_force_and_stiffness_are_read_off_the_press():
    depths, force = np.array([0.1, 0.5, 1.0]), np.array([0.1, 1.0, 3.0])
    found, stiffness = press_curve(depths, force, relative_error=0.1)
    assert (found.value, found.low, found.high) == pytest.approx((3.0, 2.7, 3.3))
    assert (stiffness.value, stiffness.low, stiffness.high) == pytest.approx((4.0, 3.6, 4.4))


def pressed_n(block: ElastomerDesign, cells_across: int) -> float:
    return float(press_centrally(block, BALL, 1.0, cells_across=cells_across).force_n[2])


@pytest.mark.slow
def test_error_of_a_force_covers_what_a_finer_lattice_changes():
    block = design("footprint_mm=[12,12]")
    force, finer = (pressed_n(block, cells) for cells in (8, 12))
    error = spacing_error(block, BALL, force, cells_across=8)
    assert 0 < error < 0.1
    assert abs(finer - force) / force < error


def test_error_of_a_force_shrinks_with_the_spacing():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ("footprint_mm=[12,12]", "lattice.spacing_mm=3"))
    errors = [spacing_error(block, BALL, pressed_n(block, cells), cells_across=cells) for cells in (4, 12)]
    assert 0 < errors[1] < errors[0] < 1


def test_press_is_the_same_as_that_of_the_whole_block():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ("footprint_mm=[12,12]", "lattice.growth=1"))
    whole = press(block, BALL, depth_mm=1.0).force_n[2]
    assert pressed_n(block, 8) == pytest.approx(whole, rel=0.05)


def test_object_that_does_not_touch_is_refused():
    with pytest.raises(ConfigError, match="does not reach the face"):
        press_centrally(design(), BALL, -1.0, cells_across=4)


def test_base_design_keeps_every_limit():
    found = printability(block_of(design()))
    assert (found.value, found.note) == (1.0, "")


def test_broken_limits_are_named():
    found = printability(block_of(design("skin_mm=2.0", "cell_mm=1.6")))
    assert found.value == pytest.approx(4 / 6)
    assert "recommended skin 0.5 to 1 mm, here 2" in found.note
    assert "printed cell 0.6 to 1 mm, here 1.57" in found.note


def test_block_without_a_grid_has_no_cells_to_judge():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ())
    assert 0 < printability(block_of(block)).value <= 1
