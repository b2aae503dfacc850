"""A flat punch and blunt cones on a deep block (Sneddon, Int. J. Eng. Sci. 3, 1965)."""

from itertools import pairwise

import numpy as np
import pytest

from magicsim.geometry.objects.kinds import parse_object

from .deep_block import LEVELS, Counts, DeepBlock, limit, order, pressed, reduced_modulus_mpa
from .layer_theory import cone, layer_contact

POISSON, HEIGHT_MM = 0.3, 20.0
MODULUS_MPA = reduced_modulus_mpa(POISSON)
PUNCH_LEVELS: tuple[Counts, ...] = ((8, 4), (12, 6), (18, 9))


def block(height_mm: float = HEIGHT_MM) -> DeepBlock:
    return DeepBlock(height_mm=height_mm, half_width_mm=height_mm, poisson=POISSON)


def test_layer_theory_tends_to_the_closed_forms() -> None:
    deep = {"height_mm": 1e4, "modulus_mpa": MODULUS_MPA, "poisson": POISSON}
    assert layer_contact(None, 1.5, **deep).force_n == pytest.approx(2 * 1.5 * MODULUS_MPA, rel=1e-3)
    conical = layer_contact(cone(70.0), 1.0, **deep)
    force = 2 / np.pi * MODULUS_MPA * np.tan(np.radians(70)) * conical.depth_mm**2
    assert conical.force_n == pytest.approx(force, rel=1e-3)
    assert conical.depth_mm == pytest.approx(np.pi / 2 / np.tan(np.radians(70)), rel=1e-3)


def cone_forces_n(half_angle_deg: float, depth_mm: float, levels: tuple[Counts, ...], height_mm: float) -> list[float]:
    tool = parse_object(f"cone:half_angle_deg={half_angle_deg},tip_radius_mm=0.05,length_mm=1").shape()
    forces = []
    for level in levels:
        solver = block(height_mm).solver(level, tolerance_mm=depth_mm / 1000)
        forces.append(float(solver.solve(pressed(tool, depth_mm)).force_n[2]))
    return forces


@pytest.mark.parametrize("half_angle_deg", [85.0, pytest.param(75.0, marks=pytest.mark.slow)])
def test_cone_presses_with_the_square_of_its_depth(half_angle_deg: float) -> None:
    """The contact radius is 1 mm, the ball of 0.05 mm at the tip removes less than 0.5 % of the depth."""
    theory = layer_contact(cone(half_angle_deg), 1.0, height_mm=HEIGHT_MM, modulus_mpa=MODULUS_MPA, poisson=POISSON)
    forces = cone_forces_n(half_angle_deg, theory.depth_mm, LEVELS, HEIGHT_MM)
    assert limit(LEVELS, forces, power=2) == pytest.approx(theory.force_n, rel=0.03)
    assert order(LEVELS, [force - theory.force_n for force in forces]) > 1.5


@pytest.mark.slow
def test_flat_punch_presses_in_proportion_to_its_radius() -> None:
    """The order is fitted to three spacings in geometric proportion: the pressure is singular at the rim.

    A rim of 0.02 mm leaves a flat face of 0.98 mm, so the radius is that to within 2 %.
    """
    depth = 0.01
    tool = parse_object("punch:radius_mm=1,edge_radius_mm=0.02").shape()
    theory = layer_contact(None, 1.0, height_mm=HEIGHT_MM, modulus_mpa=MODULUS_MPA, poisson=POISSON)
    solvers = [block().solver(level, tolerance_mm=1e-5) for level in PUNCH_LEVELS]
    forces = [float(solver.solve(pressed(tool, depth)).force_n[2]) for solver in solvers]
    first, second = (before - after for before, after in pairwise(forces))
    power = float(np.log(first / second) / np.log(1.5))
    assert power > 0.8
    assert limit(PUNCH_LEVELS, forces, power=power) == pytest.approx(theory.force_n * depth, rel=0.05)
