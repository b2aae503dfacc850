"""A coat that is felt: a coated bar against closed forms, presses against the energy of a sheet on the bare body."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from magicsim.config.models import load_preset
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.membrane import Membrane
from magicsim.deform.lattice.relaxation import Branches
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects import parse_object

MU, LAME = 0.4, 20.0
BALL = parse_object("sphere:radius_mm=3")
HALF, DEPTH = np.linspace(0.0, 4.0, 7), np.linspace(0.0, 3.0, 5)


def quarter(coat_n_per_mm: float = 0.0) -> Lattice:
    block = box_lattice((HALF, HALF, DEPTH), shear_modulus_mpa=MU, lame_mpa=LAME)
    return replace(block, is_mirrored=True, coat_n_per_mm=coat_n_per_mm)


def pressed(block: Lattice, depth_mm: float) -> Deformation:
    return ContactSolver(block, tolerance_mm=1e-5).solve(place_object(BALL, gap_mm=-depth_mm))


def sheet_energy(block: Lattice, state: Deformation) -> float:
    """What a sheet of h mu = 1 N/mm would store on a deformed face [N mm]."""
    membrane = Membrane.on(replace(block, coat_n_per_mm=1.0))
    assert membrane is not None
    positions = block.nodes_mm + state.displacements_mm
    return membrane.evaluate(positions, np.zeros_like(positions))


def stretched_bar(coat_n_per_mm: float, stretch: float) -> tuple[float, float]:
    """Force of a bar that is stretched along x, coated below, its top held flat: of the lattice, and closed form [N].

    The closed form is the homogeneous state of least energy.
    """
    x, y, z = np.linspace(0, 2, 4), np.linspace(0, 1, 3), np.linspace(0, 0.5, 3)
    bar = box_lattice((x, y, z), shear_modulus_mpa=MU, lame_mpa=LAME)
    elasticity = Elasticity.of(replace(bar, coat_n_per_mm=coat_n_per_mm))
    ends, rest = (bar.nodes_mm[:, 0] == 0) | (bar.nodes_mm[:, 0] == 2), bar.nodes_mm
    is_free = np.ones(rest.shape, bool)
    is_free[ends, 0] = is_free[rest[:, 1] == 0, 1] = is_free[rest[:, 2] == 0.5, 2] = False
    positions = rest * [stretch, stretch**-0.5, 1]

    def energy(free: np.ndarray) -> tuple[float, np.ndarray]:
        positions[is_free] = free
        state = elasticity.evaluate(positions)
        volume = LAME / 2 * elasticity.volumes @ (state.jacobian - 1) ** 2
        return state.energy_mj + float(volume), state.gradient[is_free]

    minimize(energy, positions[is_free], jac=True, method="BFGS", options={"gtol": 1e-9})
    force = elasticity.evaluate(positions).gradient[rest[:, 0] == 2, 0].sum()

    def homogeneous(across: np.ndarray, along: float) -> float:
        j, squares = along * across.prod(), along**2 + (across**2).sum()
        body = MU / 2 * (squares - 3) - MU * np.log(j) + LAME / 2 * (j - 1) ** 2
        coat = coat_n_per_mm / 2 * (along**2 + across[0] ** 2 + (along * across[0]) ** -2 - 3)
        return float(body * 1.0 + coat * 2.0)  # 1 mm3 below a face of 2 mm2

    def least(along: float) -> float:
        return float(minimize(homogeneous, np.full(2, along**-0.5), args=(along,), options={"gtol": 1e-10}).fun)

    return float(force), (least(stretch + 1e-4) - least(stretch - 1e-4)) / 2e-4 / 2.0


@pytest.mark.parametrize("stretch", [0.9, 1.1, 1.5])
def test_coated_bar_is_as_stiff_as_bar_and_coat(stretch: float) -> None:
    """An incompressible sheet and a nearly incompressible body want the same width, so that their forces add up."""
    bare, bare_theory = stretched_bar(0.0, stretch)
    coated, theory = stretched_bar(0.3, stretch)
    assert bare == pytest.approx(bare_theory, rel=1e-4)
    assert coated == pytest.approx(theory, rel=1e-3)
    sheet = 0.3 * (stretch - stretch**-2)
    assert coated - bare == pytest.approx(sheet, rel=0.02)


def test_thin_coat_adds_the_slope_of_its_energy_on_the_bare_body() -> None:
    """With W(k, depth) the least energy, dF/dk = d/d depth of dW/dk: what a sheet of k = 1 stores on the bare body."""
    depth, step, thin = 0.6, 0.02, 1e-3
    bare, coated = pressed(quarter(), depth), pressed(quarter(thin), depth)
    slope = (coated.force_n[2] - bare.force_n[2]) / thin
    energies = [sheet_energy(quarter(), pressed(quarter(), depth + sign * step)) for sign in (-1, 1)]
    assert slope == pytest.approx((energies[1] - energies[0]) / (2 * step), rel=0.02)
    assert slope > 0
    half = pressed(quarter(thin / 2), depth)
    assert half.force_n[2] - bare.force_n[2] == pytest.approx(slope * thin / 2, rel=0.02)


def test_stiffer_coat_presses_back_harder_and_dents_wider() -> None:
    states = [pressed(quarter(each), 0.8) for each in (0.0, 0.05, 0.5, 5.0)]
    forces = [float(state.force_n[2]) for state in states]
    assert forces == sorted(forces)
    assert forces[-1] > 1.5 * forces[0]
    assert all(state.converged and state.force_balance < 1e-6 for state in states)
    beside = [float(state.displacements_mm[3, 2]) for state in states]  # 2 mm beside the ball's axis
    assert beside[-1] > beside[0]


def test_coat_in_a_design_is_felt_only_with_thickness_and_modulus() -> None:
    def block(*overrides: str) -> ElastomerDesign:
        return load_preset(ElastomerDesign, "design", "gelsight-type", ["footprint_mm=[8,8]", *overrides])

    stiff = block("coat.thickness_mm=0.05", "coat.modulus_mpa=5")
    assert build_lattice(stiff).coat_n_per_mm == pytest.approx(0.05 * 5 / 3)
    bare, seen, felt = (
        press(design, BALL, depth_mm=0.5).force_n
        for design in (block().model_copy(update={"coat": None}), block(), stiff)
    )
    assert bare == seen
    assert felt[2] > 1.1 * seen[2]
    assert np.abs(felt[:2]).max() < 1e-5 * felt[2]


def test_coated_dome_is_at_rest_without_stress() -> None:
    dome = 'face={kind="dome",radius_x_mm=15,radius_y_mm=20,crown_mm=1.0,rim_mm=0.2}'
    coat = 'coat={kind="opaque",thickness_mm=0.05,modulus_mpa=20}'
    lattice = build_lattice(
        load_preset(ElastomerDesign, "design", "uniform-block", ["footprint_mm=[12,14]", dome, coat])
    )
    assert lattice.coat_n_per_mm > 0
    assert np.abs(Elasticity.of(lattice).evaluate(lattice.nodes_mm).gradient).max() < 1e-12


def test_coated_face_sticks_and_slides() -> None:
    side = np.concatenate([-HALF[:0:-1], HALF])
    block = replace(box_lattice((side, side, DEPTH), shear_modulus_mpa=MU, lame_mpa=LAME), coat_n_per_mm=0.5)
    friction = 0.5
    solver = ContactSolver(block, friction=friction)
    stuck = solver.solve(place_object(BALL, gap_mm=-0.6, x_mm=0.1), solver.solve(place_object(BALL, gap_mm=-0.6)))
    slid = solver.solve(place_object(BALL, gap_mm=-0.6, x_mm=1.5), stuck)
    assert stuck.converged
    assert slid.converged
    assert 0 < stuck.force_n[0] < 0.9 * friction * stuck.force_n[2]
    assert slid.force_n[0] == pytest.approx(friction * slid.force_n[2], rel=0.15)  # the ball's dent is inclined
    assert max(stuck.force_balance, slid.force_balance) < 1e-6


def test_coat_stays_elastic_beside_branches_that_relax() -> None:
    """A sudden press is that of the stiffer body under the coat, and after a long time that of the long-term one."""
    block, added = quarter(0.5), 0.6
    branches = Branches(times_s=np.array([1.0]), shear_modulus_mpa=np.full((1, len(block.cells)), added))
    at_once, later = (
        ContactSolver(block, tolerance_mm=1e-5, branches=branches).solve(place_object(BALL, gap_mm=-0.5), dt_s=dt)
        for dt in (0.0, np.inf)
    )
    stiff = replace(block, shear_modulus_mpa=block.shear_modulus_mpa + added)
    assert at_once.force_n[2] == pytest.approx(pressed(stiff, 0.5).force_n[2], rel=1e-4)
    # the penalty of contact goes with the instantaneous stiffness
    assert later.force_n[2] == pytest.approx(pressed(block, 0.5).force_n[2], rel=1e-4)
