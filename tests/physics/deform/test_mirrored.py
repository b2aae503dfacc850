"""A quarter of a symmetric block behaves as the block does."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice, box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

HALF = np.linspace(0.0, 4.0, 9)
DEPTH = np.linspace(0.0, 3.0, 7)
BALL = parse_object("sphere:radius_mm=3")


def lattice(*, quarter: bool, coat_n_per_mm: float = 0.0) -> Lattice:
    side = HALF if quarter else np.concatenate([-HALF[:0:-1], HALF])
    block = box_lattice((side, side, DEPTH), shear_modulus_mpa=0.4, lame_mpa=20.0)
    return replace(block, is_mirrored=quarter, coat_n_per_mm=coat_n_per_mm)


def pressed(block: Lattice, friction: float) -> Deformation:
    return ContactSolver(block, friction=friction).solve(place_object(BALL, gap_mm=-0.8))


@pytest.mark.parametrize(
    ("friction", "coat_n_per_mm"), [pytest.param(0.0, 0.0, marks=pytest.mark.slow), (1.0, 0.0), (0.0, 0.5)]
)
def test_a_quarter_carries_a_quarter_of_the_force(friction: float, coat_n_per_mm: float) -> None:
    whole, quarter = (
        pressed(lattice(quarter=is_quarter, coat_n_per_mm=coat_n_per_mm), friction) for is_quarter in (False, True)
    )
    assert 4 * quarter.force_n[2] == pytest.approx(whole.force_n[2], rel=5e-3)
    nodes = lattice(quarter=False).nodes_mm
    kept = (nodes[:, :2] > -1e-9).all(1)
    size = np.abs(whole.displacements_mm).max()
    assert np.abs(quarter.displacements_mm - whole.displacements_mm[kept]).max() < 0.02 * size


def test_planes_of_symmetry_stay_plane() -> None:
    block = lattice(quarter=True)
    state = pressed(block, 0.5)
    on_x, on_y = np.abs(block.nodes_mm[:, 0]) < 1e-9, np.abs(block.nodes_mm[:, 1]) < 1e-9
    assert np.abs(state.displacements_mm[on_x, 0]).max() == 0
    assert np.abs(state.displacements_mm[on_y, 1]).max() == 0
    assert np.abs(state.displacements_mm[on_x, 2]).max() > 0.1
    assert state.force_balance < 1e-6
