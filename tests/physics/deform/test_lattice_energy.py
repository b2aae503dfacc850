"""The lattice's energy against closed forms of the neo-Hookean solid, its zero modes and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from laboratory.stress.cases import jittered

from magicsim.deform.contact.face import contact_face
from magicsim.deform.lattice.cell_kernels import negative_log
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import spring_matrices
from magicsim.deform.lattice.pattern import block_pattern
from magicsim.deform.lattice.structure import Lattice, box_lattice

MU = 0.4


def uneven_lattice(*, poisson_ratio: float = 0.49, refine: int = 1) -> Lattice:
    planes = (np.array([-1.0, -0.4, 0.5, 1.3]), np.array([-1.0, 0.2, 1.0]), np.array([0.0, 0.3, 1.1, 2.0]))
    fine = tuple(np.interp(np.linspace(0, len(p) - 1, refine * (len(p) - 1) + 1), np.arange(len(p)), p) for p in planes)
    return box_lattice(fine, shear_modulus_mpa=MU, lame_mpa=2 * MU * poisson_ratio / (1 - 2 * poisson_ratio))


def walled_lattice(*, jitter: float = 0.0) -> Lattice:
    """Cells with structural springs, half of them, and distorted ones if asked for."""
    lattice = jittered(uneven_lattice(), share=jitter, seed=3)
    walls = np.where(np.arange(len(lattice.cells)) % 2 == 0, 0.2, 0.0)
    return replace(lattice, wall_modulus_mpa=walls)


LATTICES = {"boxes": uneven_lattice(), "walls": walled_lattice(), "distorted": walled_lattice(jitter=0.2)}


def whole_energy(elasticity: Elasticity, positions: np.ndarray) -> float:
    state = elasticity.evaluate(positions)
    volume = elasticity.lattice.lame_mpa / 2 * elasticity.volumes * (state.jacobian - 1) ** 2
    return state.energy_mj + volume.sum()


def free_hessian(lattice: Lattice, positions: np.ndarray) -> np.ndarray:
    """Dense Hessian of the free nodes."""
    elasticity = Elasticity.of(lattice)
    state = elasticity.evaluate(positions)
    pattern = block_pattern(lattice, contact_face(lattice).patches)
    pressure = lattice.lame_mpa * (state.jacobian - 1)
    values = elasticity.hessian(positions, pressure, state.volume_gradient, pattern, shift=0.0)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=(pattern.size,) * 2).toarray()
    return upper + np.triu(upper, 1).T


@pytest.mark.parametrize("poisson_ratio", [0.25, 0.49, 0.4999])
@pytest.mark.parametrize(
    "gradient",
    [
        np.diag([1.3, 1.0, 1.0]),
        np.array([[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        0.9 * np.eye(3),
        np.array([[1.1, 0.2, -0.1], [0.05, 0.9, 0.3], [0.2, -0.15, 1.2]]),
    ],
    ids=["uniaxial", "simple-shear", "volumetric", "general"],
)
def test_affine_energy_of_uneven_boxes_is_neo_hookean(gradient: np.ndarray, poisson_ratio: float) -> None:
    lattice = uneven_lattice(poisson_ratio=poisson_ratio)
    j, lame = np.linalg.det(gradient), lattice.lame_mpa[0]
    density = MU / 2 * ((gradient**2).sum() - 3) - MU * np.log(j) + lame / 2 * (j - 1) ** 2
    energy = whole_energy(Elasticity.of(lattice), lattice.nodes_mm @ gradient.T)
    assert energy == pytest.approx(density * lattice.sizes_mm.prod(1).sum(), rel=1e-12)


def test_uniaxial_traction_matches_closed_form() -> None:
    lattice = uneven_lattice()
    stretch, lame = 0.8, uneven_lattice().lame_mpa[0]
    positions = lattice.nodes_mm * [1, 1, stretch]
    force = Elasticity.of(lattice).evaluate(positions).gradient[: lattice.layer_nodes].sum(0)
    nominal = MU * (stretch - 1 / stretch) + lame * (stretch - 1)
    area = np.prod([np.ptp(planes) for planes in lattice.planes_mm[:2]])
    np.testing.assert_allclose(force, [0, 0, -nominal * area], rtol=1e-10, atol=1e-12)


def test_affine_motion_of_distorted_cells_is_exact_and_in_equilibrium() -> None:
    lattice = jittered(uneven_lattice(refine=2), share=0.2, seed=4)
    gradient = np.array([[1.1, 0.2, -0.1], [0.05, 0.9, 0.3], [0.2, -0.15, 1.2]])
    positions, j, lame = lattice.nodes_mm @ gradient.T, np.linalg.det(gradient), lattice.lame_mpa[0]
    elasticity = Elasticity.of(lattice)
    density = MU / 2 * ((gradient**2).sum() - 3) - MU * np.log(j) + lame / 2 * (j - 1) ** 2
    assert whole_energy(elasticity, positions) == pytest.approx(density * 2.3 * 2 * 2, rel=1e-12)
    inner = np.ones(len(positions), bool)
    for axis, planes in enumerate(lattice.planes_mm):
        inner &= (lattice.nodes_mm[:, axis] > planes[0]) & (lattice.nodes_mm[:, axis] < planes[-1])
    assert inner.sum() > 10
    np.testing.assert_allclose(elasticity.evaluate(positions).gradient[inner], 0, atol=1e-13)


def test_walls_add_a_neo_hookean_fibre_along_each_axis() -> None:
    plain, walled = uneven_lattice(), replace(uneven_lattice(), wall_modulus_mpa=np.full(18, 0.15))
    gradient = np.array([[0.9, 0.2, 0.0], [0.1, 1.1, 0.0], [0.0, 0.1, 0.95]])
    squares = (gradient**2).sum(0)
    fibres = 0.15 * ((squares - 1 - np.log(squares)) / 2).sum()
    energies = [whole_energy(Elasticity.of(lattice), lattice.nodes_mm @ gradient.T) for lattice in (plain, walled)]
    assert energies[1] - energies[0] == pytest.approx(fibres * 2.3 * 2 * 2, rel=1e-12)


def test_springs_are_never_negative() -> None:
    sizes = np.random.default_rng(0).uniform(0.05, 3, (200, 3))
    springs = -spring_matrices(sizes, np.ones(200))[:, ~np.eye(8, dtype=bool)]
    assert (springs >= -1e-12 / 4).all()
    assert (springs.max(1) > 0).all()


@pytest.mark.parametrize("lattice", LATTICES.values(), ids=LATTICES)
def test_gradient_is_the_derivative_of_the_energy(lattice: Lattice) -> None:
    elasticity, rng = Elasticity.of(lattice), np.random.default_rng(1)
    positions = lattice.nodes_mm + 0.03 * rng.normal(size=lattice.nodes_mm.shape)
    direction, step = rng.normal(size=positions.shape), 1e-5
    above, below = (whole_energy(elasticity, positions + s * step * direction) for s in (1, -1))
    numeric = above - below
    exact = (elasticity.evaluate(positions).gradient * direction).sum()
    assert numeric / (2 * step) == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize("lattice", LATTICES.values(), ids=LATTICES)
def test_hessian_is_the_derivative_of_the_gradient(lattice: Lattice) -> None:
    elasticity, rng = Elasticity.of(lattice), np.random.default_rng(2)
    positions = lattice.nodes_mm + 0.03 * rng.normal(size=lattice.nodes_mm.shape)
    direction, free = np.zeros_like(positions), lattice.free_nodes
    direction[:free] = rng.normal(size=(free, 3))
    step = 1e-5
    above, below = (elasticity.evaluate(positions + s * step * direction).gradient for s in (1, -1))
    numeric = above - below
    exact = free_hessian(lattice, positions) @ direction[:free].ravel()
    np.testing.assert_allclose(numeric[:free].ravel() / (2 * step), exact, atol=1e-7 * np.abs(exact).max())


@pytest.mark.parametrize("lattice", LATTICES.values(), ids=LATTICES)
def test_unbonded_lattice_has_exactly_six_zero_modes(lattice: Lattice) -> None:
    elasticity = Elasticity.of(lattice)
    size, step = lattice.nodes_mm.size, 1e-5
    columns = []
    for dof in range(size):
        direction = np.zeros(size)
        direction[dof] = step
        shift = direction.reshape(-1, 3)
        above, below = (elasticity.evaluate(lattice.nodes_mm + s * shift).gradient for s in (1, -1))
        columns.append((above - below).ravel() / (2 * step))
    modes = np.linalg.eigvalsh(np.array(columns))
    assert np.abs(modes[:6]).max() < 1e-8 * modes[-1]
    assert modes[6] > 1e-4 * modes[-1]


def test_energy_of_a_smooth_field_converges_with_second_order() -> None:
    errors, energies = [], []
    for refine in (1, 2, 4, 8, 16):
        lattice = uneven_lattice(poisson_ratio=0.3, refine=refine)
        x, y, z = lattice.nodes_mm.T
        field = 0.1 * np.stack([np.sin(x + z), np.cos(y - z) * x, np.sin(x * y)], 1)
        energies.append(whole_energy(Elasticity.of(lattice), lattice.nodes_mm + field))
    limit = energies[-1] + (energies[-1] - energies[-2]) / 3
    errors = np.abs(np.array(energies[1:4]) - limit)
    slopes = np.log2(errors[:-1] / errors[1:])
    assert (slopes > 1.85).all()


def test_logarithm_continues_smoothly_and_keeps_nan() -> None:
    for at in (0.1 + 1e-9, 0.1 - 1e-9):
        np.testing.assert_allclose(negative_log(at), (np.log(10), -10, 100), rtol=1e-6)
    assert np.isfinite(negative_log(-3.0)).all()
    assert np.isnan(negative_log(np.nan)).all()
