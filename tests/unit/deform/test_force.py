import numpy as np
import pytest

from magicsim import load_design, load_object, press
from magicsim.deform.indentation.force import FORCE_SHARE, MOST_SOLVES, find_depth, press_to_force
from magicsim.geometry.indenter import place_object


@pytest.mark.parametrize("force_n", [0.1, 1.0, 6.0])
@pytest.mark.parametrize(
    "law", [lambda d: 2.5 * d**1.5, lambda d: 10.0 * d, lambda d: 3.0 * d + 1.5 * d**3, lambda d: max(0.0, 4 * d - 0.5)]
)
def test_depth_at_a_force_is_found_on_few_places(law, force_n: float):
    found = find_depth(law, force_n, deepest_mm=2.5)
    assert found.is_met
    assert law(found.depth_mm) == pytest.approx(force_n, rel=FORCE_SHARE)
    assert found.force_n == law(found.depth_mm)
    assert found.solves <= (7 if law(0.1) > 0 else MOST_SOLVES)  # an object that touches late takes longer


def test_force_that_is_not_reached_ends_at_the_deepest_place():
    found = find_depth(lambda depth: depth, 6.0, deepest_mm=2.5)
    assert (found.is_met, found.depth_mm, found.force_n) == (False, 2.5, 2.5)


def test_force_that_jumps_past_what_is_asked_ends_below_the_jump():
    found = find_depth(lambda depth: 1.0 if depth < 1 else 5.0, 3.0, deepest_mm=2.5)
    assert not found.is_met
    assert (found.force_n, found.solves) == (1.0, MOST_SOLVES)
    assert found.depth_mm < 1


SYMMETRIC_N = 2e-6
"""Sideways force of a whole centred press, which a factor of single precision leaves; that of a quarter is zero."""


def pressed(design, thing):
    return lambda depth: [place_object(thing, gap_mm=-depth, x_mm=0.0, y_mm=0.0, design=design)] * 2


@pytest.mark.parametrize(("friction", "quality"), [(0.0, "full"), (0.6, "full"), (0.6, "control")])
def test_press_ends_at_the_force_that_a_press_to_its_depth_has(friction: float, quality: str):
    design = load_design("uniform-block", ["footprint_mm=[12,12]", "lattice.spacing_mm=1.5", "limits.force_n=1"])
    ball = load_object("sphere:radius_mm=3")
    found = press_to_force(design, pressed(design, ball), 0.8, deepest_mm=2.0, friction=friction, quality=quality)
    assert found.is_met
    assert found.force_n == pytest.approx(0.8, rel=FORCE_SHARE)
    own = press(design, ball, depth_mm=found.depth_mm, friction=friction)
    if quality == "full":
        assert found.state.force_n[2] == pytest.approx(own.force_n[2], rel=1e-6)
        np.testing.assert_allclose(found.state.force_n[:2], own.force_n[:2], atol=SYMMETRIC_N)
    assert own.force_n[2] == pytest.approx(found.force_n, rel=0.03)
    assert found.solves <= 8
