"""A sphere on a deep block: Hertz's force and contact radius, and how the spacing's error falls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from .deep_block import LEVELS, Counts, DeepBlock, ball, contact_radius_mm, limit, order, reduced_modulus_mpa
from .layer_theory import Contact, layer_contact, sphere

RADIUS_MM, DEEP_RADIUS_MM, CONTACT_MM, POISSON = 50.0, 10.0, 1.0, 0.3
MODULUS_MPA = reduced_modulus_mpa(POISSON)
FINE_LEVELS: tuple[Counts, ...] = ((9, 6), (12, 8), (15, 10))


@dataclass(frozen=True, slots=True, kw_only=True)
class Presses:
    """One press at several spacings, to the depth at which the contact radius is 1 mm."""

    theory: Contact
    forces_n: list[float]
    radii_mm: list[float]


def theory(height_mm: float, *, radius_mm: float = RADIUS_MM, poisson: float = POISSON) -> Contact:
    modulus = reduced_modulus_mpa(poisson)
    return layer_contact(sphere(radius_mm), CONTACT_MM, height_mm=height_mm, modulus_mpa=modulus, poisson=poisson)


def hertz_n(depth_mm: float, *, radius_mm: float = RADIUS_MM, modulus_mpa: float = MODULUS_MPA) -> float:
    return float(4 / 3 * modulus_mpa * np.sqrt(radius_mm) * depth_mm**1.5)


def presses_on(height_mm: float, levels: Sequence[Counts], *, radius_mm: float = RADIUS_MM) -> Presses:
    block = DeepBlock(height_mm=height_mm, half_width_mm=height_mm, poisson=POISSON)
    expected = theory(height_mm, radius_mm=radius_mm)
    forces, radii = [], []
    for level in levels:
        solver = block.solver(level, tolerance_mm=expected.depth_mm / 1000)
        state = solver.solve(ball(radius_mm, expected.depth_mm))
        forces.append(float(state.force_n[2]))
        radii.append(contact_radius_mm(state, solver))
    return Presses(theory=expected, forces_n=forces, radii_mm=radii)


@pytest.fixture(scope="module")
def presses() -> Presses:
    return presses_on(20.0, LEVELS)


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_layer_theory_starts_as_published_and_tends_to_hertz(poisson: float) -> None:
    """Dimitriadis et al., Biophys. J. 82 (2002): a bonded layer to the first order in chi = sqrt(R d) / h."""
    height = 200.0
    expected = theory(height, poisson=poisson)
    alpha = -(1.2876 - 1.4678 * poisson + 1.3442 * poisson**2) / (1 - poisson)
    chi = np.sqrt(RADIUS_MM * expected.depth_mm) / height
    ratio = expected.force_n / hertz_n(expected.depth_mm, modulus_mpa=reduced_modulus_mpa(poisson))
    assert ratio == pytest.approx(1 - 2 * alpha / np.pi * chi, abs=2e-4)


def test_force_converges_with_the_square_of_the_spacing(presses: Presses) -> None:
    assert order(LEVELS, [force - presses.theory.force_n for force in presses.forces_n]) > 1.7


def test_force_tends_to_that_of_a_layer_of_this_depth(presses: Presses) -> None:
    """The finite depth, a/h = 1/20, adds 4.6 % to Hertz; it is in the theory."""
    assert limit(LEVELS, presses.forces_n, power=2) == pytest.approx(presses.theory.force_n, rel=0.01)


def test_contact_radius_squared_is_radius_times_depth(presses: Presses) -> None:
    """On the finite depth it is the radius that belongs to the force, a^3 = 3 F R / 4 E*."""
    half_space_depth = (presses.theory.force_n / hertz_n(1.0)) ** (2 / 3)
    assert presses.radii_mm[-1] == pytest.approx(np.sqrt(RADIUS_MM * half_space_depth), rel=0.03)
    assert presses.radii_mm[-1] == pytest.approx(CONTACT_MM, rel=0.03)


@pytest.mark.slow
def test_force_is_that_of_hertz_on_a_deep_block() -> None:
    """a/R = 1/10, a/h = 1/60: the finite depth alone adds 1.5 %."""
    presses = presses_on(60.0, FINE_LEVELS, radius_mm=DEEP_RADIUS_MM)
    closed_form = hertz_n(presses.theory.depth_mm, radius_mm=DEEP_RADIUS_MM)
    assert limit(FINE_LEVELS, presses.forces_n, power=2) == pytest.approx(closed_form, rel=0.03)
    assert order(FINE_LEVELS, [force - presses.theory.force_n for force in presses.forces_n]) > 1.5
