"""Core cell: exact limits, bounds, convergence, and the finite strain of a cell of neo-Hookean walls and infill."""

import numpy as np
import pytest

from magicsim.deform.lattice.cell_kernels import wall_energy
from magicsim.deform.lattice.cell_problem import CellStiffness, cell_fields
from magicsim.deform.lattice.follow import fluctuation, rotation_and_strain, strain_components

from .wall_patch import follow_path, mean_stress, periodic_cell

BODY, INFILL, SHARE = (0.369, 18.3), (0.017, 1000.0), 0.512
COARSE = (3, 1)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_one_material_gives_itself_back(share: float) -> None:
    cell = cell_fields(body=BODY, infill=BODY, infill_share=share, subcells=5).stiffness
    assert cell.shear_modulus_mpa == pytest.approx(BODY[0], rel=1e-8)
    assert cell.bulk_modulus_mpa == pytest.approx(BODY[1], rel=1e-8)
    assert cell.tetragonal_modulus_mpa == pytest.approx(BODY[0], rel=1e-8)
    assert cell.wall_modulus_mpa == pytest.approx(0, abs=1e-8)


def test_moduli_lie_between_reuss_and_voigt_bounds() -> None:
    cell = cell_fields(body=BODY, infill=INFILL, infill_share=SHARE).stiffness
    soft_shear = 1 / ((1 - SHARE) / BODY[0] + SHARE / INFILL[0])
    soft_bulk = 1 / ((1 - SHARE) / BODY[1] + SHARE / INFILL[1])
    stiff_bulk = (1 - SHARE) * BODY[1] + SHARE * INFILL[1]
    stiff_shear = (1 - SHARE) * BODY[0] + SHARE * INFILL[0]
    assert soft_bulk < cell.bulk_modulus_mpa < stiff_bulk
    for modulus in (cell.c44_mpa, cell.tetragonal_modulus_mpa):
        assert soft_shear < modulus < stiff_shear


def test_matches_hashin_shtrikman_upper_bound_within_reach() -> None:
    """A closed-cell foam of stiff walls lies below the upper bound of an isotropic mixture, and not far."""
    cell = cell_fields(body=(1.0, 3.0), infill=(0.5, 1.5), infill_share=0.3).stiffness
    bulk = 3.0 + 0.3 / (1 / (1.5 - 3.0) + 0.7 * 3 / (3 * 3.0 + 4 * 1.0))
    assert cell.bulk_modulus_mpa <= bulk * (1 + 1e-3)
    assert cell.bulk_modulus_mpa == pytest.approx(bulk, rel=0.02)


def test_network_walls_and_pressure_add_up_to_the_cubic_constants() -> None:
    cell = cell_fields(body=BODY, infill=INFILL, infill_share=SHARE).stiffness
    mu, beta, lame = cell.shear_modulus_mpa, cell.wall_modulus_mpa, cell.lame_mpa
    assert lame + 2 * mu + 2 * beta == pytest.approx(cell.c11_mpa, rel=1e-12)
    assert lame == pytest.approx(cell.c12_mpa, rel=1e-12)
    assert mu == cell.c44_mpa


@pytest.mark.parametrize("share", [0.05, 0.3, 0.7, 0.95])
@pytest.mark.parametrize("contrast", [1e-6, 1e-3, 0.3, 30.0])
def test_walls_always_add_stiffness_along_their_axes(share: float, contrast: float) -> None:
    infill = (BODY[0] * contrast, 1000.0)
    assert cell_fields(body=BODY, infill=infill, infill_share=share, subcells=5).stiffness.wall_modulus_mpa > 0


def test_refinement_changes_little() -> None:
    coarse, fine = (cell_fields(body=BODY, infill=INFILL, infill_share=SHARE, subcells=n).stiffness for n in (5, 8))
    for name in ("c44_mpa", "tetragonal_modulus_mpa", "bulk_modulus_mpa"):
        assert getattr(coarse, name) == pytest.approx(getattr(fine, name), rel=0.01)


@pytest.fixture(scope="module")
def cell():
    return periodic_cell(body=BODY, infill=INFILL, share=SHARE, parts=COARSE)


@pytest.fixture(scope="module")
def stiffness(cell) -> CellStiffness:
    """Constants of the reference's own mesh, so that what the law is tested for is finite strain alone."""
    small = 1e-4
    axial = stress_of(cell, small * np.diag([1, 0, 0])) / small
    squeeze = stress_of(cell, small * np.diag([1, -1, 0])) / small
    shear = stress_of(cell, small * np.outer([1, 0, 0], [0, 0, 1])) / small
    bulk, tetragonal = np.trace(axial) / 3, (squeeze[0, 0] - squeeze[1, 1]) / 4
    return CellStiffness(c11_mpa=bulk + 4 / 3 * tetragonal, c12_mpa=bulk - 2 / 3 * tetragonal, c44_mpa=shear[0, 2])


def path(cell, gradients):
    model, moving = cell
    return follow_path(model, moving, [model.lattice.nodes_mm @ (f - np.eye(3)).T for f in gradients])


def stress_of(cell, change: np.ndarray) -> np.ndarray:
    return mean_stress(cell[0], path(cell, [np.eye(3) + change])[0])


def test_small_strain_of_an_independent_solution_agrees(stiffness: CellStiffness) -> None:
    cell = cell_fields(body=BODY, infill=INFILL, infill_share=SHARE).stiffness
    assert stiffness.bulk_modulus_mpa == pytest.approx(cell.bulk_modulus_mpa, rel=2e-3)
    assert stiffness.tetragonal_modulus_mpa == pytest.approx(cell.tetragonal_modulus_mpa, rel=5e-3)
    assert stiffness.c44_mpa == pytest.approx(cell.c44_mpa, rel=0.025)  # eight elements against a graded sixteen


def squeezed(strain: float) -> np.ndarray:
    return np.diag([(1 - strain) ** -0.5, (1 - strain) ** -0.5, 1 - strain])


def squeezed_rate(strain: float) -> np.ndarray:
    return np.diag([(1 - strain) ** -1.5 / 2, (1 - strain) ** -1.5 / 2, -1.0])


def sheared(strain: float) -> np.ndarray:
    return np.eye(3) + strain * np.outer([1, 0, 0], [0, 0, 1])


def sheared_rate(_: float) -> np.ndarray:
    return np.outer([1.0, 0, 0], [0, 0, 1.0])


@pytest.mark.parametrize(
    ("gradient", "rate"), [(squeezed, squeezed_rate), (sheared, sheared_rate)], ids=["squeezed", "sheared"]
)
@pytest.mark.parametrize("sign", [1, -1])
def test_lattice_law_follows_the_cell_to_thirty_percent(cell, stiffness: CellStiffness, gradient, rate, sign) -> None:
    """Power of the stress of network and walls against the neo-Hookean cell's, volume kept, squeezed and stretched."""
    strains = sign * np.array([0.1, 0.2, 0.3])
    mu, beta = stiffness.shear_modulus_mpa, stiffness.wall_modulus_mpa
    for strain, state in zip(strains, path(cell, [gradient(strain) for strain in strains]), strict=True):
        f = gradient(strain)
        slope = np.array([wall_energy(square, mu / (2 * beta))[1] for square in (f**2).sum(0)])
        law = mu * (f - np.linalg.inv(f).T) + 2 * beta * f * slope
        exact = (mean_stress(cell[0], state) * rate(strain)).sum()
        assert (law * rate(strain)).sum() == pytest.approx(exact, rel=0.03)


def test_compressed_walls_tilt_as_the_cell_does(cell, stiffness: CellStiffness) -> None:
    """Stiffness against tilting, mu + 2 beta f', at 25 % compression: half of that at rest, within 5 % of it."""
    stretch, small = 0.75, 1e-3
    tilted = squeezed(0.25) + small * np.outer([1, 0, 0], [0, 0, 1])
    half = squeezed(0.125)
    stress = mean_stress(cell[0], path(cell, [half, squeezed(0.25), tilted])[-1])
    mu, beta = stiffness.shear_modulus_mpa, stiffness.wall_modulus_mpa
    law = mu + 2 * beta * wall_energy(stretch**2, mu / (2 * beta))[1]
    assert law < 0.6 * mu
    assert stress[0, 2] / small == pytest.approx(law, abs=0.05 * mu)


@pytest.mark.parametrize(
    ("gradient", "at_5_percent", "at_20_percent"),
    [(squeezed, 0.15, 0.25), (sheared, 0.07, 0.13)],
    ids=["squeezed", "sheared"],
)
def test_correctors_give_the_fluctuation_of_the_cell(cell, gradient, at_5_percent: float, at_20_percent: float) -> None:
    """Part of the interface's fluctuation that is missed; a squeezed cell has hardly any."""
    model, _ = cell
    nodes = model.lattice.nodes_mm
    interface = np.flatnonzero(np.isclose(np.abs(nodes - 0.5).max(1), SHARE ** (1 / 3) / 2))
    chi = fluctuation(cell_fields(body=BODY, infill=INFILL, infill_share=SHARE), nodes[interface])
    strains, errors = (0.05, 0.1, 0.15, 0.2), []
    for strain, state in zip(strains, path(cell, map(gradient, strains)), strict=True):
        f = gradient(strain)
        exact = (state.displacements_mm - nodes @ (f - np.eye(3)).T)[interface]
        rotation, stretch = rotation_and_strain(f[None])
        corrected = chi @ strain_components(stretch)[0] @ rotation[0].T
        errors.append(np.linalg.norm(corrected - exact) / np.linalg.norm(exact))
    assert errors[0] < at_5_percent
    assert errors[-1] < at_20_percent
