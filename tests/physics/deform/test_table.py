"""A block on a table: closed forms without friction, the bonded block with much of it, Coulomb's law between."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.structure import Lattice, TableTop, box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

from .deep_block import SHEAR_MPA, DeepBlock, ball, reduced_modulus_mpa
from .layer_theory import layer_contact, sphere

HALF = np.linspace(0.0, 4.0, 7)
DEPTH = np.linspace(0.0, 3.0, 6)
MU, LAME = 0.4, 20.0
WEIGHT = TableTop(friction=0.7, weight_mpa=3e-5)
HEAVY_MPA = 10.0
"""A weight that keeps the base down: the layers of the theory do not lift off."""


def lattice(table: TableTop | None, *, quarter: bool = True) -> Lattice:
    side = HALF if quarter else np.concatenate([-HALF[:0:-1], HALF])
    block = box_lattice((side, side, DEPTH), shear_modulus_mpa=MU, lame_mpa=LAME)
    return replace(block, is_mirrored=quarter, table=table)


def pressed(block: Lattice, *, depth_mm: float = 0.8) -> Deformation:
    return ContactSolver(block).solve(place_object(parse_object("sphere:radius_mm=3"), gap_mm=-depth_mm))


def base(block: Lattice, state: Deformation) -> tuple[np.ndarray, np.ndarray]:
    """Force of the table on each node of the base, the weight left out, shape (nodes, 3) [N], and their motion [mm]."""
    elasticity = Elasticity.of(replace(block, table=None))
    held = elasticity.evaluate(block.nodes_mm + state.displacements_mm).gradient[-block.layer_nodes :]
    return held, state.displacements_mm[-block.layer_nodes :]


def areas() -> np.ndarray:
    """Of the nodes of the base of a whole block, shape (nodes,) [mm2]."""
    share = np.convolve(np.diff(np.concatenate([-HALF[:0:-1], HALF])) / 2, [1, 1])
    return np.outer(share, share).ravel()


def test_forces_derive_from_the_energy() -> None:
    block = lattice(WEIGHT)
    table = Elasticity.of(block).table
    assert table is not None
    rng = np.random.default_rng(0)
    limits = rng.uniform(0, 0.05, block.layer_nodes)
    table = replace(table, memory=replace(table.memory, limit_mpa=limits))
    positions = block.nodes_mm + 1e-3 * rng.normal(size=block.nodes_mm.shape)
    way = rng.normal(size=positions.shape)
    above, below = (table.evaluate(positions + sign * 1e-8 * way).energy_mj for sign in (1, -1))
    work = -(table.evaluate(positions).node_force_n * way[table.first :]).sum()
    assert (above - below) / 2e-8 == pytest.approx(work, rel=1e-5)


def test_nothing_moves_at_rest() -> None:
    block = lattice(WEIGHT, quarter=False)
    assert np.abs(Elasticity.of(block).evaluate(block.nodes_mm).gradient).max() < 1e-12


def test_a_smooth_table_under_a_plate_leaves_uniaxial_stress() -> None:
    depth = 0.6
    block = lattice(replace(WEIGHT, friction=0.0))
    plate = parse_object("box:size_mm=30x30x5,edge_radius_mm=0.1")
    state = ContactSolver(block, tolerance_mm=1e-5).solve(place_object(plate, gap_mm=-depth))
    axial = 1 - depth / block.height_mm

    def sideways(stretch: float) -> float:
        return MU * (stretch - 1 / stretch) + LAME * (stretch**2 * axial - 1) * stretch * axial

    side = brentq(sideways, 1, 2)
    stress = MU * (axial - 1 / axial) + LAME * (side**2 * axial - 1) * side**2
    assert state.force_n[2] == pytest.approx(-stress * 16, rel=2e-3)
    corner = block.nodes_mm[-1] + state.displacements_mm[-1]
    np.testing.assert_allclose(corner[:2], 4 * side, rtol=1e-3)


@pytest.mark.parametrize("is_bonded", [True, False])
def test_layer_theory_on_a_smooth_or_bonded_base(is_bonded: bool) -> None:
    deep = DeepBlock(
        height_mm=2.0, half_width_mm=10.0, poisson=0.499, spread_per_mm=0.7, flat_mm=1.0, flat_depth_mm=1.0
    )
    block = deep.lattice((10, 7))
    if not is_bonded:
        block = replace(block, table=TableTop(friction=1e-4, weight_mpa=HEAVY_MPA))
    contact = 1.1
    theory = layer_contact(
        sphere(12.0), contact, height_mm=2.0, modulus_mpa=reduced_modulus_mpa(0.499), poisson=0.499, is_bonded=is_bonded
    )
    solver = ContactSolver(block, tolerance_mm=theory.depth_mm / 1000, point_spacing_mm=10.0)
    state = solver.solve(ball(12.0, theory.depth_mm))
    assert SHEAR_MPA == 1.0
    assert state.force_n[2] == pytest.approx(theory.force_n, rel=0.04)


def test_much_friction_is_a_bonded_base_under_compression() -> None:
    bonded, held = (pressed(lattice(each)) for each in (None, replace(WEIGHT, friction=50.0)))
    assert held.force_n[2] == pytest.approx(bonded.force_n[2], rel=3e-3)


def test_less_friction_is_softer_and_forces_balance() -> None:
    forces = []
    for friction in (0.0, 0.3, 1.5):
        block = lattice(replace(WEIGHT, friction=friction))
        state = pressed(block)
        held, _ = base(block, state)
        forces.append(float(state.force_n[2]))
        assert state.force_balance < 1e-6
        assert held.sum(0)[2] == pytest.approx(-state.force_n[2], rel=1e-3)
    assert forces[0] < 0.95 * forces[1] < 0.95 * forces[2]


def test_friction_keeps_to_coulombs_law_and_opposes_the_slip() -> None:
    friction = 0.3
    block = lattice(replace(WEIGHT, friction=friction), quarter=False)
    state = pressed(block)
    held, moved = base(block, state)
    pressure, shear = -held[:, 2], np.linalg.norm(held[:, :2], axis=1)
    largest = pressure.max()
    assert (pressure > -1e-3 * largest).all()
    assert (shear <= friction * pressure + 0.01 * friction * largest).all()
    slips = (np.linalg.norm(moved[:, :2], axis=1) > 0.01) & (pressure > 0.1 * largest)
    assert slips.any()
    assert ((held[slips, :2] * moved[slips, :2]).sum(1) < 0).all()
    np.testing.assert_allclose(shear[slips], friction * pressure[slips], rtol=0.05)


@pytest.mark.slow
def test_a_block_that_is_turned_over_lifts_off_against_its_weight_alone() -> None:
    block = lattice(replace(WEIGHT, friction=1.5), quarter=False)
    solver, thing, state = ContactSolver(block, friction=5.0), parse_object("sphere:radius_mm=3"), None
    for way in (0.0, 0.5, 1.0, 1.5):
        state = solver.solve(place_object(thing, gap_mm=-0.3, x_mm=way), state)
    assert state is not None
    held, moved = base(block, state)
    behind = block.nodes_mm[-block.layer_nodes :, 0] < -3.9
    assert (moved[behind, 2] < -1e-3).all()
    np.testing.assert_allclose(held[behind, 2].sum(), WEIGHT.weight_mpa * areas()[behind].sum(), rtol=1e-3)
    assert state.force_balance < 1e-6


@pytest.mark.slow
def test_a_quarter_is_a_quarter_of_the_whole() -> None:
    whole, quarter = (pressed(lattice(WEIGHT, quarter=each)) for each in (False, True))
    assert 4 * quarter.force_n[2] == pytest.approx(whole.force_n[2], rel=1e-2)
    assert np.abs(whole.force_n[:2]).max() < 1e-3 * whole.force_n[2]


def test_a_block_that_is_dragged_slides_at_its_friction() -> None:
    friction = 0.2
    block = lattice(replace(WEIGHT, friction=friction), quarter=False)
    solver, thing, state = ContactSolver(block, friction=5.0), parse_object("sphere:radius_mm=3"), None
    for way in (0.0, 0.5, 1.0, 1.5):
        state = solver.solve(place_object(thing, gap_mm=-0.6, x_mm=way), state)
    assert state is not None
    weight = WEIGHT.weight_mpa * 64
    assert state.force_n[0] == pytest.approx(friction * (state.force_n[2] + weight), rel=0.01)
    _, moved = base(block, state)
    assert moved[:, 0].min() > 0.1
