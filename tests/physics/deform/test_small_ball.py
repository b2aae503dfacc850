"""A ball much smaller than the lattice's spacing: the cells across its contact decide how stiff it looks."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

SYMMETRIC_MM = 1e-6
"""Iterations end where forces balance to 1e-8, with a factor of single precision on the way: not all of its last digits
are symmetric."""


def force_n(cells_across: int) -> float:
    design = load_preset(
        ElastomerDesign, "design", "uniform-block", ["footprint_mm=[8,8]", f"lattice.cells_across={cells_across}"]
    )
    return press(design, parse_object("sphere:radius_mm=0.5"), depth_mm=0.6).force_n[2]


def test_default_cells_are_enough_and_none_are_not() -> None:
    fine = force_n(8)
    assert force_n(4) == pytest.approx(fine, rel=0.05)
    assert force_n(0) > 1.2 * fine


def test_symmetric_press_gives_symmetric_answer() -> None:
    design = load_preset(ElastomerDesign, "design", "uniform-block", ["footprint_mm=[8,8]"])
    pose = place_object(parse_object("sphere:radius_mm=0.5"), gap_mm=-0.6)
    lattice = build_lattice(design, zone=contact_zone([pose], design))
    moved = ContactSolver(lattice).solve(pose).displacements_mm
    grid = moved.reshape(*(len(planes) for planes in lattice.planes_mm[::-1]), 3)
    np.testing.assert_allclose(grid, grid[:, :, ::-1] * [-1, 1, 1], atol=SYMMETRIC_MM)
    np.testing.assert_allclose(grid, grid[:, ::-1] * [1, -1, 1], atol=SYMMETRIC_MM)
    np.testing.assert_allclose(grid, grid.transpose(0, 2, 1, 3)[..., [1, 0, 2]], atol=SYMMETRIC_MM)
