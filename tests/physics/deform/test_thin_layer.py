"""Bonded, nearly incompressible layers under a sphere: the formula of Long et al., and the lubrication limit.

A layer of thickness h much smaller than the contact radius b moves like a lubricant. With pressure p(r) and shear
modulus mu, mu u'' = p' across it. Bonded below and free to slide above, u = p' (z^2 - 2 h z) / 2 mu and the flux is
q = -p' h^3 / 3 mu; held on both faces, u = p' z (z - h) / 2 mu and q = -p' h^3 / 12 mu: that is the factor of four, and
"frictionless" means the sphere's side only. An incompressible layer carries away what the sphere displaces,
2 pi r q = 2 pi int_0^r (d - s^2 / 2R) s ds, so q = d r / 2 - r^3 / 8R. Beyond the edge there is neither pressure nor
flux, so q(b) = 0, b^2 = 4 R d, and frictionless

    p = (3 mu / 32 R h^3) (b^2 - r^2)^2,    F = pi mu b^6 / 32 R h^3 = 2 pi mu R^2 d^3 / h^3.

Pressed in one load step a held point stays where it stood at rest, so the same holds with four times the force. Towards
the rim shear falls like b^2 - r^2 and pressure like its square, so the outermost points slip at any friction. It needs
h << b, d b << h^2 and a bulk modulus far above mu (b / h)^2.
"""

import numpy as np
import pytest

from .deep_block import SHEAR_MPA, Cap, Counts, DeepBlock, ball, order, pressed, reduced_modulus_mpa
from .layer_theory import layer_contact, sphere

POISSON = 0.49999
LAYER = DeepBlock(height_mm=1.0, half_width_mm=40.0, poisson=POISSON, spread_per_mm=0.0)
THIN_RADIUS_MM, THIN_DEPTH_MM = 4.5e4, 0.005
"""b/h = 30, d b / h^2 = 0.15."""
THIN_LEVELS: tuple[Counts, ...] = ((8, 2), (12, 3), (16, 4))
"""The edge lies on the sixth, ninth and twelfth plane from the axis: errors of edges between planes scatter."""


def long_n(radius_mm: float, height_mm: float, depth_mm: float) -> float:
    """Long, Hall, Wu and Hui, Biophys. J. 101 (2011): neo-Hookean, nu = 0.5, R/h <= 2, d <= min(0.6 h, 0.4 R)."""
    ratio = height_mm / radius_mm
    omega = (radius_mm * depth_mm / height_mm**2) ** 1.5
    alpha, beta = 10.05 - 0.63 * np.sqrt(ratio) * (3.1 + ratio**2), 4.8 - 4.23 * ratio**2
    factor = (1 + 1.15 * omega ** (1 / 3) + alpha * omega + beta * omega**2) / (1 + 2.3 * omega)
    return float(16 / 3 * SHEAR_MPA * np.sqrt(radius_mm) * depth_mm**1.5 * factor)


def lubrication_n(radius_mm: float, depth_mm: float) -> float:
    return float(2 * np.pi * SHEAR_MPA * radius_mm**2 * depth_mm**3 / LAYER.height_mm**3)


def long_block() -> DeepBlock:
    return DeepBlock(
        height_mm=4.0, half_width_mm=12.0, poisson=0.499, spread_per_mm=0.7, flat_mm=1.5, flat_depth_mm=1.5
    )


@pytest.mark.parametrize("depth_mm", [0.4, 0.8])
def test_sphere_on_a_layer_presses_as_long_et_al_found(depth_mm: float) -> None:
    state = long_block().solver((9, 6), tolerance_mm=depth_mm / 1000).solve(ball(4.0, depth_mm))
    assert state.force_n[2] == pytest.approx(long_n(4.0, 4.0, depth_mm), rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("depth_mm", [0.4, 0.8])
def test_sphere_on_a_layer_converges(depth_mm: float) -> None:
    levels = ((6, 4), (9, 6), (13, 9))
    solvers = [long_block().solver(level, tolerance_mm=depth_mm / 1000) for level in levels]
    forces = [float(solver.solve(ball(4.0, depth_mm)).force_n[2]) for solver in solvers]
    assert forces[-1] == pytest.approx(long_n(4.0, 4.0, depth_mm), rel=0.03)
    assert abs(forces[1] - forces[2]) < 0.6 * abs(forces[0] - forces[1])


@pytest.fixture(scope="module")
def exact_n() -> float:
    """Force of the thin layer by linear theory at any b/h."""
    modulus, edge = reduced_modulus_mpa(POISSON), np.sqrt(4 * THIN_RADIUS_MM * THIN_DEPTH_MM)
    contacts = [
        layer_contact(sphere(THIN_RADIUS_MM), share * edge, height_mm=1.0, modulus_mpa=modulus, poisson=POISSON)
        for share in np.linspace(0.9, 1.0, 6)
    ]
    depths, forces = [each.depth_mm for each in contacts], [each.force_n for each in contacts]
    return float(np.interp(THIN_DEPTH_MM, depths, forces))


def thin_force_n(level: Counts) -> float:
    solver = LAYER.solver(level, tolerance_mm=THIN_DEPTH_MM / 2000)
    return float(solver.solve(pressed(Cap(THIN_RADIUS_MM), THIN_DEPTH_MM)).force_n[2])


def test_layer_theory_is_lubrication_on_a_thin_layer(exact_n: float) -> None:
    assert exact_n == pytest.approx(lubrication_n(THIN_RADIUS_MM, THIN_DEPTH_MM), rel=0.02)


def test_thin_layer_slides_below_a_frictionless_sphere(exact_n: float) -> None:
    force = thin_force_n((12, 3))
    assert force == pytest.approx(lubrication_n(THIN_RADIUS_MM, THIN_DEPTH_MM), rel=0.05)
    assert force == pytest.approx(exact_n, rel=0.03)


@pytest.mark.slow
def test_thin_layer_converges_with_the_square_of_the_spacing(exact_n: float) -> None:
    errors = [thin_force_n(level) - exact_n for level in THIN_LEVELS]
    assert order(THIN_LEVELS, errors) > 1.5


@pytest.mark.slow
def test_thin_layer_held_by_the_sphere_is_four_times_stiffer() -> None:
    level = THIN_LEVELS[-1]
    solver = LAYER.solver(level, tolerance_mm=THIN_DEPTH_MM / 1000, friction=10.0)
    state = solver.solve(pressed(Cap(THIN_RADIUS_MM), THIN_DEPTH_MM))
    radius = np.linalg.norm(state.contact_points_mm[:, :2], axis=1)
    rim = np.sqrt(4 * THIN_RADIUS_MM * THIN_DEPTH_MM) - LAYER.half_width_mm / level[0]
    assert (radius[state.is_slipping] > rim).all()
    assert state.force_n[2] == pytest.approx(4 * lubrication_n(THIN_RADIUS_MM, THIN_DEPTH_MM), rel=0.05)
