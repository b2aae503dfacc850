"""A pressed sphere that is sheared or twisted: Cattaneo and Mindlin's stick radius, full slip, stiffness, torque.

The blocks are nearly incompressible, so that pressure and shear do not couple (Johnson, Contact Mechanics, 7.2).
"""

import numpy as np
import pytest

from .deep_block import (
    LEVELS,
    SHEAR_MPA,
    Counts,
    DeepBlock,
    ball,
    contact_radius_mm,
    mean_square_radius_mm2,
    order,
    reduced_modulus_mpa,
)
from .layer_theory import Contact, layer_contact, sphere

POISSON, RADIUS_MM, TOLERANCE_MM = 0.49, 50.0, 2e-5
STICKS = 2.0
"""Friction that holds all but the rim of the contact in the small motions here."""
RIM_ON_PLANES_MM = 1.1727
"""Fine part of a block of 20 mm whose planes of `LEVELS` meet the contact radius of 1 mm."""


def cube(height_mm: float) -> tuple[DeepBlock, Contact]:
    """A block, and the press to a contact radius of 1 mm on it."""
    modulus = reduced_modulus_mpa(POISSON)
    contact = layer_contact(sphere(RADIUS_MM), 1.0, height_mm=height_mm, modulus_mpa=modulus, poisson=POISSON)
    return DeepBlock(height_mm=height_mm, half_width_mm=height_mm, poisson=POISSON), contact


def stick_ratio(mean_square: float) -> float:
    """c/a from <r^2> / a^2 of the tangential traction mu (p of radius a - c/a p of radius c), bisected."""
    low, high = 0.0, 1 - 1e-9
    for _ in range(50):
        ratio = (low + high) / 2
        below = 0.4 * (1 - ratio**5) / (1 - ratio**3) < mean_square
        low, high = (ratio, high) if below else (low, ratio)
    return (low + high) / 2


@pytest.mark.parametrize("level", [(9, 5), pytest.param((12, 7), marks=pytest.mark.slow)])
def test_stick_radius_is_that_of_cattaneo_and_mindlin(level: Counts) -> None:
    """c/a = (1 - Q / mu P)^(1/3); measured by the second moment of the traction, as single points scatter."""
    friction = 0.3
    block, press = cube(6.0)
    solver = block.solver(level, tolerance_mm=TOLERANCE_MM, friction=friction)
    state = solver.solve(ball(RADIUS_MM, press.depth_mm))
    contact = contact_radius_mm(state, solver)
    slipping = []
    for share in (0.3, 0.6):
        full_slip = 3 * friction * press.force_n * (2 - POISSON) / (16 * SHEAR_MPA)
        state = solver.solve(ball(RADIUS_MM, press.depth_mm, x_mm=share * full_slip), state)
        load = state.force_n[0] / (friction * state.force_n[2])
        measured = stick_ratio(mean_square_radius_mm2(state, solver, axis=0) / contact**2)
        assert measured == pytest.approx((1 - load) ** (1 / 3), rel=0.05)
        slipping.append(state.is_slipping.sum())
        stuck = (state.contact_pressure_mpa > 0) & ~state.is_slipping
        radius = np.linalg.norm(state.contact_points_mm[:, :2], axis=1)
        assert radius[stuck].mean() < radius[state.is_slipping].mean()
    assert 0 < slipping[0] < slipping[1]


def test_full_slip_pulls_with_the_coefficient_of_friction() -> None:
    friction = 0.3
    block, press = cube(6.0)
    solver = block.solver((7, 4), tolerance_mm=TOLERANCE_MM, friction=friction)
    state = solver.solve(ball(RADIUS_MM, press.depth_mm))
    full_slip = 3 * friction * press.force_n * (2 - POISSON) / (16 * SHEAR_MPA)
    state = solver.solve(ball(RADIUS_MM, press.depth_mm, x_mm=1.5 * full_slip), state)
    assert state.is_slipping.sum() == (state.contact_pressure_mpa > 0).sum()
    assert state.force_n[0] == pytest.approx(friction * state.force_n[2], rel=5e-3)


@pytest.mark.slow
def test_small_shear_meets_the_stiffness_of_mindlin() -> None:
    """Q = 8 G a x / (2 - nu), with the contact radius measured.

    The rim lies on the second, third and fourth plane from the axis: errors of rims between planes scatter.
    """
    _, press = cube(20.0)
    block = DeepBlock(height_mm=20.0, half_width_mm=20.0, poisson=POISSON, flat_mm=RIM_ON_PLANES_MM)
    x_mm, errors = 1e-3, []
    for level in LEVELS:
        solver = block.solver(level, tolerance_mm=TOLERANCE_MM / 4, friction=STICKS)
        still = solver.solve(ball(RADIUS_MM, press.depth_mm))
        sheared = solver.solve(ball(RADIUS_MM, press.depth_mm, x_mm=x_mm), still)
        stiffness = 8 * SHEAR_MPA * contact_radius_mm(still, solver) / (2 - POISSON)
        errors.append(float(sheared.force_n[0]) / x_mm / stiffness - 1)
    assert order(LEVELS, errors) > 1
    assert abs(errors[-1]) < 0.02


@pytest.mark.parametrize("level", [(12, 7), pytest.param((14, 9), marks=pytest.mark.slow)])
def test_small_twist_meets_the_torque_of_reissner_and_sagoci(level: Counts) -> None:
    """T = 16/3 G a^3 theta (J. Appl. Phys. 15, 1944), with the contact radius measured.

    The traction is singular at the rim, so coarse lattices miss some of it: 7 % with 8 cells across.
    """
    block, press = cube(4.0)
    angle = 1e-3
    solver = block.solver(level, tolerance_mm=TOLERANCE_MM, friction=STICKS)
    still = solver.solve(ball(RADIUS_MM, press.depth_mm))
    twisted = solver.solve(ball(RADIUS_MM, press.depth_mm, twist_deg=float(np.degrees(angle))), still)
    torque = 16 / 3 * SHEAR_MPA * contact_radius_mm(still, solver) ** 3 * angle
    assert twisted.torque_nmm[2] == pytest.approx(torque, rel=0.05)
