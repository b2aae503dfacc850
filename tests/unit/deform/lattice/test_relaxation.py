"""Relaxation branches: a potential for fixed history, the stress they stand for, rest, rotation, a design's moduli."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from laboratory.stress.cases import jittered
from scipy.spatial.transform import Rotation

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import contact_face
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS, gauss_geometry
from magicsim.deform.lattice.pattern import block_pattern
from magicsim.deform.lattice.relaxation import FULL, UNIT, Branches, Relaxation, RelaxationState, branch_moduli
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign

BOXES = box_lattice(
    (np.array([-1.0, -0.4, 0.5, 1.3]), np.array([-1.0, 0.2, 1.0]), np.array([0.0, 0.3, 1.1, 2.0])),
    shear_modulus_mpa=0.4,
    lame_mpa=9.0,
)
BENT = jittered(BOXES, share=0.2, seed=0)
BRANCHES = Branches(
    times_s=np.array([0.05, 2.0]),
    shear_modulus_mpa=np.random.default_rng(3).uniform(0.5, 2, (2, len(BOXES.cells))),
)
PATH_S = (0.0, 0.03, 0.5, 0.2)
"""Steps of the motion behind `moved_state`."""
TERMS = [(0.1, 3.0), (10.0, 0.6)]


@pytest.fixture(params=[BOXES, BENT], ids=["boxes", "bent"])
def relaxation(request: pytest.FixtureRequest) -> Relaxation:
    return Relaxation.of(Elasticity.of(request.param), BRANCHES)


def random_positions(relaxation: Relaxation, seed: int) -> np.ndarray:
    nodes = relaxation.elasticity.lattice.nodes_mm
    return nodes + 0.03 * np.random.default_rng(seed).normal(size=nodes.shape)


def moved_state(relaxation: Relaxation, turn: np.ndarray | None = None) -> RelaxationState:
    state, turn = relaxation.rest(), np.eye(3) if turn is None else turn
    for seed, dt_s in enumerate(PATH_S):
        state = relaxation.advanced(state, random_positions(relaxation, seed) @ turn.T, dt_s=dt_s)
    return state


def whole_energy(elasticity: Elasticity, positions: np.ndarray) -> float:
    state = elasticity.evaluate(positions)
    volume = elasticity.lattice.lame_mpa / 2 * elasticity.volumes * (state.jacobian - 1) ** 2
    return state.energy_mj + volume.sum()


def deformation_gradients(lattice: Lattice, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    inverse, weights = gauss_geometry(lattice.nodes_mm[lattice.cells])
    gradients = np.einsum("qpk,cqki->cqpi", GAUSS_GRADIENTS, inverse)
    return np.einsum("cpi,cqpk->cqik", positions[lattice.cells], gradients), gradients, weights


@pytest.mark.parametrize("dt_s", [0.0, 1e-9, 0.01, 3.0, 1e6, np.inf])
def test_rest_stays_rest(relaxation: Relaxation, dt_s: float) -> None:
    rest = relaxation.rest()
    elastic = relaxation.timed_elasticity(rest, dt_s=dt_s).evaluate(relaxation.elasticity.lattice.nodes_mm)
    np.testing.assert_allclose(elastic.gradient, 0, atol=1e-13)
    assert elastic.energy_mj == pytest.approx(0, abs=1e-12)
    state = relaxation.advanced(rest, relaxation.elasticity.lattice.nodes_mm, dt_s=dt_s)
    np.testing.assert_allclose(state.tensors, rest.tensors, atol=1e-14)


def test_inverse_metric_is_that_of_the_deformation(relaxation: Relaxation) -> None:
    gradient = deformation_gradients(relaxation.elasticity.lattice, random_positions(relaxation, 7))[0]
    expected = np.linalg.inv(gradient.transpose(0, 1, 3, 2) @ gradient)
    state = relaxation.advanced(relaxation.rest(), random_positions(relaxation, 7), dt_s=0.1)
    np.testing.assert_allclose(state.inverse_metric[:, :, FULL], expected, rtol=1e-12, atol=1e-12)


def test_sudden_step_leaves_the_networks_as_they_are(relaxation: Relaxation) -> None:
    before = moved_state(relaxation)
    after = relaxation.advanced(before, random_positions(relaxation, 7), dt_s=0.0)
    np.testing.assert_array_equal(after.tensors, before.tensors)


@pytest.mark.parametrize("dt_s", [0.0, 0.02, 5.0])
def test_gradient_is_the_force_of_the_branches_after_the_step(dt_s: float) -> None:
    relaxation = Relaxation.of(Elasticity.of(BENT), BRANCHES)
    before, positions = moved_state(relaxation), random_positions(relaxation, 8)
    after = relaxation.advanced(before, positions, dt_s=dt_s)
    f, gradients, weights = deformation_gradients(BENT, positions)
    stress = f[None] @ after.tensors[..., FULL] - np.linalg.inv(f).transpose(0, 1, 3, 2)
    forces = np.einsum("bc,cq,bcqik,cqpk->cpi", BRANCHES.shear_modulus_mpa, weights, stress, gradients)
    expected = relaxation.elasticity.evaluate(positions).gradient
    np.add.at(expected, BENT.cells, forces)
    timed = relaxation.timed_elasticity(before, dt_s=dt_s).evaluate(positions)
    np.testing.assert_allclose(timed.gradient, expected, atol=1e-12)


@pytest.mark.parametrize("dt_s", [0.0, 0.02, 5.0])
def test_step_has_a_potential(relaxation: Relaxation, dt_s: float) -> None:
    elasticity = relaxation.timed_elasticity(moved_state(relaxation), dt_s=dt_s)
    positions, step = random_positions(relaxation, 8), 1e-5
    direction = np.random.default_rng(9).normal(size=positions.shape)
    above, below = (whole_energy(elasticity, positions + sign * step * direction) for sign in (1, -1))
    exact = (elasticity.evaluate(positions).gradient * direction).sum()
    assert (above - below) / (2 * step) == pytest.approx(exact, rel=1e-7)


def test_hessian_of_a_step_is_the_derivative_of_its_gradient(relaxation: Relaxation) -> None:
    elasticity = relaxation.timed_elasticity(moved_state(relaxation), dt_s=0.02)
    lattice, positions, step = elasticity.lattice, random_positions(relaxation, 8), 1e-5
    free, pattern = lattice.free_nodes, block_pattern(lattice, contact_face(lattice).patches)
    state = elasticity.evaluate(positions)
    pressure = lattice.lame_mpa * (state.jacobian - 1)
    values = elasticity.hessian(positions, pressure, state.volume_gradient, pattern, shift=0.0)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=(pattern.size,) * 2).toarray()
    direction = np.zeros_like(positions)
    direction[:free] = np.random.default_rng(9).normal(size=(free, 3))
    exact = (upper + np.triu(upper, 1).T) @ direction[:free].ravel()
    above, below = (elasticity.evaluate(positions + sign * step * direction).gradient for sign in (1, -1))
    numeric = ((above - below) / (2 * step))[:free].ravel()
    np.testing.assert_allclose(numeric, exact, atol=1e-7 * np.abs(exact).max())


def test_forces_turn_with_the_body_and_its_history_does_not(relaxation: Relaxation) -> None:
    turn = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    still, turned = moved_state(relaxation), moved_state(relaxation, turn)
    np.testing.assert_allclose(turned.tensors, still.tensors, atol=1e-12)
    np.testing.assert_allclose(turned.corners_mm, still.corners_mm, atol=1e-12)
    forces = [
        relaxation.timed_elasticity(state, dt_s=0.1).evaluate(random_positions(relaxation, 8) @ own.T).gradient
        for state, own in ((still, np.eye(3)), (still, turn))
    ]
    np.testing.assert_allclose(forces[1], forces[0] @ turn.T, atol=1e-12)


def test_steps_with_a_straight_metric_add_up(relaxation: Relaxation) -> None:
    """Halving a step changes nothing as long as C^-1 is linear in time: here it is constant."""
    state, positions = moved_state(relaxation), random_positions(relaxation, 8)
    state = relaxation.advanced(state, positions, dt_s=0.0)
    once = relaxation.advanced(state, positions, dt_s=0.6)
    for _ in range(3):
        state = relaxation.advanced(state, positions, dt_s=0.2)
    np.testing.assert_allclose(state.tensors, once.tensors, atol=1e-13)
    np.testing.assert_allclose(state.corners_mm, once.corners_mm, atol=1e-13)


@pytest.mark.parametrize("dt_s", [0.0, 0.01, 1.0])
def test_held_shape_is_free_of_the_branches_in_the_end(relaxation: Relaxation, dt_s: float) -> None:
    positions = random_positions(relaxation, 8)
    state = relaxation.advanced(moved_state(relaxation), positions, dt_s=0.0)
    state = relaxation.advanced(state, positions, dt_s=1e4)
    timed = relaxation.timed_elasticity(state, dt_s=dt_s).evaluate(positions)
    np.testing.assert_allclose(timed.gradient, relaxation.elasticity.evaluate(positions).gradient, atol=1e-12)


@pytest.mark.parametrize("sizes_mm", [(1, 1, 1), (1.2, 0.9, 0.4), (2.0, 0.3, 0.3), (3, 3, 0.2), (0.1, 3, 1)])
def test_excess_of_the_springs_stores_energy_and_takes_no_force_in_an_affine_motion(sizes_mm: tuple) -> None:
    """Positive semi-definite: its share of the dissipation, mu/tau |x - Z F^T|^2 by this matrix, is not negative."""
    lattice = box_lattice(tuple(np.array([0.0, size]) for size in sizes_mm), shear_modulus_mpa=0.4, lame_mpa=9.0)
    branches = Branches(times_s=np.ones(1), shear_modulus_mpa=np.ones((1, 1)))
    excess = Relaxation.of(Elasticity.of(lattice), branches).excess[0]
    scale = np.abs(excess).max()
    np.testing.assert_allclose(excess @ lattice.nodes_mm, 0, atol=1e-13 * scale)
    assert np.linalg.eigvalsh(excess).min() >= -1e-12 * scale


@pytest.mark.parametrize("dt_s", [-0.1, np.nan])
def test_step_back_in_time_raises(relaxation: Relaxation, dt_s: float) -> None:
    with pytest.raises(ConfigError, match=r"^dt_s = .* is not allowed: must be 0 or more$"):
        relaxation.timed_elasticity(relaxation.rest(), dt_s=dt_s)


@pytest.mark.parametrize("terms", [[(0.0, 1.0)], [(1.0, -1.0)], [(1.0, 1.0), (np.nan, 1.0)]])
def test_prony_terms_that_are_not_physical_raise(terms: list) -> None:
    design = load_preset(ElastomerDesign, "design", "uniform-block")
    with pytest.raises(ConfigError, match=r"^Prony terms .* are not allowed"):
        branch_moduli(design, BOXES, terms)


def test_skin_takes_the_series_of_the_body() -> None:
    design = load_preset(ElastomerDesign, "design", "uniform-block")
    lattice = build_lattice(design)
    branches = branch_moduli(design, lattice, TERMS)
    np.testing.assert_array_equal(branches.times_s, [0.1, 10.0])
    expected = np.array([[3.0], [0.6]]) / (2 * (1 + design.materials.body.poisson_ratio))
    np.testing.assert_allclose(branches.shear_modulus_mpa, np.tile(expected, len(lattice.cells)))


def test_core_reaches_the_stiffness_of_a_design_with_instantaneous_walls() -> None:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ("lattice.spacing_mm=2",))
    lattice, body = build_lattice(design), design.materials.body
    branches = branch_moduli(design, lattice, TERMS)
    extra = 3.6 / (2 * (1 + body.poisson_ratio))
    shear, bulk = body.shear_modulus_mpa + extra, body.bulk_modulus_mpa + 2 / 3 * extra
    ratio = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))
    stiff = body.model_copy(update={"youngs_modulus_mpa": 2 * shear * (1 + ratio), "poisson_ratio": ratio})
    materials = design.materials.model_copy(update={"body": stiff})
    fast = build_lattice(design.model_copy(update={"materials": materials}))
    slow_modulus, fast_modulus = (each.shear_modulus_mpa + 0.4 * each.wall_modulus_mpa for each in (lattice, fast))
    core = lattice.is_core
    assert core.any()
    np.testing.assert_allclose(branches.shear_modulus_mpa.sum(0)[core], (fast_modulus - slow_modulus)[core], rtol=1e-9)
    np.testing.assert_allclose(branches.shear_modulus_mpa[0], 5 * branches.shear_modulus_mpa[1])
    assert branches.shear_modulus_mpa[0, core].max() < 0.5 * branches.shear_modulus_mpa[0, ~core].min()


def test_no_terms_leave_the_lattice_as_it_is() -> None:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ("lattice.spacing_mm=2",))
    lattice = build_lattice(design)
    elasticity = Elasticity.of(lattice)
    relaxation = Relaxation.of(elasticity, branch_moduli(design, lattice, []))
    timed = relaxation.timed_elasticity(relaxation.rest(), dt_s=0.1)
    np.testing.assert_array_equal(timed.springs, elasticity.springs)
    np.testing.assert_array_equal(timed.log_modulus_mpa, elasticity.log_modulus_mpa)


def test_fast_and_slow_steps_are_the_instantaneous_and_the_long_term_lattice(relaxation: Relaxation) -> None:
    rest, positions = relaxation.rest(), random_positions(relaxation, 8)
    lattice = relaxation.elasticity.lattice
    stiff = replace(lattice, shear_modulus_mpa=lattice.shear_modulus_mpa + BRANCHES.shear_modulus_mpa.sum(0))
    fast = relaxation.timed_elasticity(rest, dt_s=0.0).evaluate(positions)
    expected = Elasticity.of(stiff).evaluate(positions)
    np.testing.assert_allclose(fast.gradient, expected.gradient, atol=1e-12)
    assert fast.energy_mj == pytest.approx(expected.energy_mj, rel=1e-12)
    slow = relaxation.timed_elasticity(moved_state(relaxation), dt_s=1e10).evaluate(positions)
    np.testing.assert_allclose(slow.gradient, relaxation.elasticity.evaluate(positions).gradient, atol=1e-9)


def test_unit_tensor_is_the_identity() -> None:
    np.testing.assert_array_equal(UNIT[FULL], np.eye(3))
