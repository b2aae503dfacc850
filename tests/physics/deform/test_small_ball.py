"""A ball much smaller than the lattice's spacing: the cells across its contact decide how stiff it looks."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.solve.problem import Problem
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

SYMMETRIC_MM = {"single": 2e-6, "double": 1e-12}
"""A factor of single precision, whose last digits are not symmetric, leaves its mark on the multipliers of contact; one
of double precision does not."""


def force_n(cells_across: int) -> float:
    design = load_preset(
        ElastomerDesign, "design", "uniform-block", ["footprint_mm=[8,8]", f"lattice.cells_across={cells_across}"]
    )
    return press(design, parse_object("sphere:radius_mm=0.5"), depth_mm=0.6).force_n[2]


def test_default_cells_are_enough_and_none_are_not() -> None:
    fine = force_n(8)
    assert force_n(4) == pytest.approx(fine, rel=0.05)
    assert force_n(0) > 1.2 * fine


@pytest.mark.parametrize("precision", SYMMETRIC_MM)
def test_symmetric_press_gives_symmetric_answer(precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Problem, "is_well_conditioned", precision == "single")
    design = load_preset(ElastomerDesign, "design", "uniform-block", ["footprint_mm=[8,8]"])
    pose = place_object(parse_object("sphere:radius_mm=0.5"), gap_mm=-0.6)
    lattice = build_lattice(design, zone=contact_zone([pose], design))
    moved = ContactSolver(lattice).solve(pose).displacements_mm
    atol = SYMMETRIC_MM[precision]
    grid = moved.reshape(*(len(planes) for planes in lattice.planes_mm[::-1]), 3)
    np.testing.assert_allclose(grid, grid[:, :, ::-1] * [-1, 1, 1], atol=atol)
    np.testing.assert_allclose(grid, grid[:, ::-1] * [1, -1, 1], atol=atol)
    np.testing.assert_allclose(grid, grid.transpose(0, 2, 1, 3)[..., [1, 0, 2]], atol=atol)


def test_a_light_touch_far_from_the_middle_ends_where_rounding_is_left():
    """Positions of small cells are rounded by their distance from the origin, and 3e-11 N are then never in balance."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[16,20]", "lattice.spacing_mm=1.2"])
    ball = parse_object("sphere:radius_mm=2.5")
    lattice = build_lattice(design, zone=contact_zone([place_object(ball, gap_mm=-0.05, x_mm=5, y_mm=6)], design))
    state = ContactSolver(lattice, friction=0.6).solve(place_object(ball, gap_mm=-0.005, x_mm=5, y_mm=6))
    assert state.iterations < 10
