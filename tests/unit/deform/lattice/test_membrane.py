"""The coat's membrane: closed forms of a stretched sheet, derivatives, rest on any face, rotations."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from magicsim.deform.contact.face import contact_face
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.membrane import LEAST_SQUARE, Membrane
from magicsim.deform.lattice.pattern import block_pattern
from magicsim.deform.lattice.structure import Lattice, box_lattice

COAT = 0.7
X, Y = np.array([-1.0, -0.4, 0.5, 1.3]), np.array([-1.0, 0.2, 1.0])
AREA = float(np.ptp(X) * np.ptp(Y))


def coated(*, curvature: float = 0.0, stiffness: float = COAT) -> Lattice:
    """Uneven boxes, their contact face bulged to z = (x^2 + x y + 2 y^2) times a curvature."""
    block = box_lattice((X, Y, np.array([0.0, 0.5, 1.2])), shear_modulus_mpa=0.4, lame_mpa=10.0)
    x, y, z = block.nodes_mm.T
    bulged = np.stack([x, y, z + curvature * (x * x + x * y + 2 * y * y) * (1 - z / 1.2)], 1)
    return replace(block, nodes_mm=bulged, coat_n_per_mm=stiffness)


def sheet(lattice: Lattice) -> Membrane:
    found = Membrane.on(lattice)
    assert found is not None
    return found


def forces(lattice: Lattice, positions: np.ndarray) -> tuple[float, np.ndarray]:
    """Energy and its gradient."""
    gradient = np.zeros_like(positions)
    return sheet(lattice).evaluate(positions, gradient), gradient


def moved(lattice: Lattice, *, seed: int = 0) -> np.ndarray:
    return lattice.nodes_mm + 0.08 * np.random.default_rng(seed).normal(size=lattice.nodes_mm.shape)


def dense(lattice: Lattice, positions: np.ndarray, *, shift: float = 0.0) -> np.ndarray:
    """Hessian of the membrane alone, of all nodes that are free."""
    pattern = block_pattern(lattice, contact_face(lattice).patches)
    values = np.zeros(len(pattern.indices))
    sheet(lattice).add_stiffness(positions, pattern, values, shift=shift)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=(pattern.size,) * 2).toarray()
    return np.asarray(upper + np.triu(upper, 1).T)


@pytest.mark.parametrize("stretch", [0.8, 1.0, 1.3, 2.0])
def test_uniaxial_stretch_is_that_of_a_neo_hookean_sheet(stretch: float) -> None:
    lattice = coated()
    energy, gradient = forces(lattice, lattice.nodes_mm * [stretch, stretch**-0.5, 1])
    assert energy == pytest.approx(COAT / 2 * AREA * (stretch**2 + 2 / stretch - 3), abs=1e-14)
    end = lattice.nodes_mm[:, 0] == X[-1]
    assert gradient[end, 0].sum() == pytest.approx(COAT * np.ptp(Y) * (stretch - stretch**-2), abs=1e-14)
    side = lattice.nodes_mm[:, 1] == Y[-1]
    assert gradient[side, 1].sum() == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("stretch", [0.9, 1.2, 1.8])
def test_equibiaxial_stretch_is_that_of_a_neo_hookean_sheet(stretch: float) -> None:
    lattice = coated()
    energy, gradient = forces(lattice, lattice.nodes_mm * [stretch, stretch, 1])
    assert energy == pytest.approx(COAT / 2 * AREA * (2 * stretch**2 + stretch**-4 - 3), abs=1e-14)
    end = lattice.nodes_mm[:, 0] == X[-1]
    assert gradient[end, 0].sum() == pytest.approx(COAT * np.ptp(Y) * (stretch - stretch**-5), abs=1e-14)


def test_small_stretch_has_the_moduli_of_plane_stress() -> None:
    """E h = 3 mu h along, and half of the stretch across (nu = 1/2): E h / (1 - nu^2) where the width is held."""
    lattice, small = coated(), 1e-6
    end = lattice.nodes_mm[:, 0] == X[-1]
    held = forces(lattice, lattice.nodes_mm * [1 + small, 1, 1])[1][end, 0].sum()
    assert held / (small * np.ptp(Y)) == pytest.approx(3 * COAT / (1 - 0.5**2), rel=1e-5)


@pytest.mark.parametrize("curvature", [0.0, 0.2])
def test_forces_and_stiffness_are_derivatives_of_the_energy(curvature: float) -> None:
    lattice = coated(curvature=curvature)
    positions, way = moved(lattice), np.random.default_rng(1).normal(size=lattice.nodes_mm.shape)
    way[lattice.free_nodes :] = 0
    step = 1e-6
    (above, up), (below, down) = (forces(lattice, positions + sign * step * way) for sign in (1, -1))
    assert (above - below) / (2 * step) == pytest.approx((forces(lattice, positions)[1] * way).sum(), rel=1e-8)
    change = ((up - down) / (2 * step))[: lattice.free_nodes].ravel()
    np.testing.assert_allclose(dense(lattice, positions) @ way[: lattice.free_nodes].ravel(), change, atol=1e-7)


def test_energy_goes_on_smoothly_for_folded_facets() -> None:
    lattice, limit = coated(), LEAST_SQUARE**0.25  # the squared ratio of areas is the fourth power of a stretch
    below, above = (lattice.nodes_mm * [stretch, stretch, 1] for stretch in (limit * (1 - 1e-6), limit * (1 + 1e-6)))
    (energy, gradient), (other, turned) = forces(lattice, below), forces(lattice, above)
    assert energy == pytest.approx(other, rel=1e-4)
    np.testing.assert_allclose(gradient, turned, rtol=1e-4, atol=1e-4 * np.abs(turned).max())
    stiffness = dense(lattice, above)
    np.testing.assert_allclose(dense(lattice, below), stiffness, rtol=1e-4, atol=1e-4 * np.abs(stiffness).max())
    energy, gradient = forces(lattice, lattice.nodes_mm * [0, 0, 1])
    assert np.isfinite(energy)
    assert np.isfinite(gradient).all()


@pytest.mark.parametrize("curvature", [0.0, 0.2])
def test_rest_is_free_of_stress_and_turns_are_free(curvature: float) -> None:
    lattice = coated(curvature=curvature)
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    for positions in (lattice.nodes_mm, lattice.nodes_mm @ turn.T + [1, 2, 3]):
        energy, gradient = forces(lattice, positions)
        assert abs(energy) < 1e-14
        assert np.abs(gradient).max() < 1e-14
    strained = moved(lattice)
    energy, gradient = forces(lattice, strained)
    turned, twisted = forces(lattice, strained @ turn.T)
    assert turned == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(twisted, gradient @ turn.T, atol=1e-13)


def test_sheet_at_rest_resists_stretch_and_nothing_else() -> None:
    lattice = coated()
    spectrum = np.linalg.eigvalsh(dense(lattice, lattice.nodes_mm))
    assert spectrum.min() > -1e-12
    face = lattice.layer_nodes
    in_plane = 2 * face - 3
    assert (spectrum > 1e-6).sum() == in_plane


def test_taut_sheet_is_stable_and_a_shift_makes_any_stiffer() -> None:
    lattice = coated()
    assert np.linalg.eigvalsh(dense(lattice, lattice.nodes_mm * [1.2, 1.1, 1])).min() > -1e-12
    squeezed = lattice.nodes_mm * [0.9, 0.9, 1]
    assert np.linalg.eigvalsh(dense(lattice, squeezed)).min() < -0.01
    assert np.linalg.eigvalsh(dense(lattice, squeezed, shift=4.0)).min() > -1e-12


def test_no_coat_costs_nothing() -> None:
    bare = coated(stiffness=0.0)
    assert Membrane.on(bare) is None
    assert Elasticity.of(bare).coat is None
