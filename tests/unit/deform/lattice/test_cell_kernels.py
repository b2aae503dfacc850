"""The law of structural springs: small strain, smoothness, and its bound."""

import numpy as np
import pytest

from magicsim.deform.lattice.cell_kernels import wall_energy

RHO = 0.9


def test_small_strain_is_eps_squared() -> None:
    for strain in (1e-4, -1e-4):
        assert wall_energy((1 + strain) ** 2, RHO)[0] == pytest.approx(strain**2, rel=1e-3)


@pytest.mark.parametrize("square", [2.0, 1.0, 0.7, 0.45, 0.44, 0.2, 0.01])
def test_derivatives_match_finite_differences(square: float) -> None:
    step = 1e-6
    above, below = wall_energy(square + step, RHO), wall_energy(square - step, RHO)
    _, first, second = wall_energy(square, RHO)
    assert (above[0] - below[0]) / (2 * step) == pytest.approx(first, abs=1e-8)
    assert (above[1] - below[1]) / (2 * step) == pytest.approx(second, rel=1e-5, abs=1e-5)


def test_law_is_twice_continuous_where_it_leaves_the_fibre() -> None:
    start = 1 / (1 + 2 * 0.7 * RHO)
    np.testing.assert_allclose(wall_energy(start - 1e-12, RHO), wall_energy(start + 1e-12, RHO), rtol=1e-9)


@pytest.mark.parametrize("rho", [0.1, 0.9, 5.0])
def test_a_tenth_of_the_shear_stiffness_is_always_left(rho: float) -> None:
    """What keeps a compressed cell elliptic is mu + 2 beta f' > 0, which is rho + f' > 0."""
    slopes = np.array([wall_energy(square, rho)[1] for square in np.geomspace(1e-8, 1, 200)])
    assert (slopes + rho >= 0.1 * rho * (1 - 1e-9)).all()
