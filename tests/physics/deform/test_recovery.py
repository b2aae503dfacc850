"""A dent that an object has left: it recovers as the body relaxes, and a second touch finds what is left of it."""

import numpy as np
import pytest

from magicsim.deform.lattice.relaxation import body_branches
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.solve.path import RECOVERED_MM, ContactSolver
from magicsim.geometry.design import load_design
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.plain import SphereObject

DEPTH_MM = 0.4
TIME_S = 1.0
SETTINGS = ("footprint_mm=[8,8]", f"materials.body.prony=[{{time_s={TIME_S},modulus_mpa=1.0}}]")


def solver(*, recovers=True, friction=0.0):
    design = load_design("uniform-block", SETTINGS)
    lattice = build_lattice(design)
    return ContactSolver(lattice, branches=body_branches(design, lattice), recovers=recovers, friction=friction)


def ball(gap_mm, x_mm=0.0):
    return place_object(SphereObject(kind="sphere", radius_mm=3.0), gap_mm=gap_mm, x_mm=x_mm)


def dent_mm(state):
    return float(state.displacements_mm[:, 2].max())


def pressed_and_left(solve, *, held_s=2.0):
    """States after a press that was held, and 0.05 s after the object has left."""
    pressed = solve.solve(ball(-DEPTH_MM), None, dt_s=0.05)
    held = solve.solve(ball(-DEPTH_MM), pressed, dt_s=held_s)
    return held, solve.solve(ball(1.0), held, dt_s=0.05)


def test_a_dent_recovers_by_the_time_of_the_branch():
    solve = solver()
    held, left = pressed_and_left(solve)
    assert np.linalg.norm(left.force_n) == 0
    assert 0.1 * dent_mm(held) < dent_mm(left) < 0.9 * dent_mm(held)
    dents, state = [dent_mm(left)], left
    for _ in range(6):
        state = solve.solve(ball(1.0), state, dt_s=0.5)
        dents.append(dent_mm(state))
    assert (np.diff(dents) < 0).all()
    # A standard solid recovers at constant load with tau (E + E_1) / E, here for moduli in shear.
    body = load_design("uniform-block", SETTINGS).materials.body
    slowed = TIME_S * body.instantaneous_shear_modulus_mpa / body.shear_modulus_mpa
    rate = np.polyfit(0.5 * np.arange(len(dents)), np.log(dents), 1)[0]
    assert -1 / rate == pytest.approx(slowed, rel=0.15)


def test_a_second_touch_soon_after_finds_the_dent():
    solve = solver()
    first = solve.solve(ball(-DEPTH_MM), None, dt_s=0.05)
    _, left = pressed_and_left(solve)
    forces = []
    for pause_s in (0.1, 2.0, 50.0):
        waited = solve.solve(ball(1.0), left, dt_s=pause_s)
        forces.append(solve.solve(ball(-DEPTH_MM), waited, dt_s=0.05).force_n[2])
    assert forces[0] < 0.9 * forces[2]
    assert forces == sorted(forces)
    assert forces[2] == pytest.approx(first.force_n[2], rel=0.02)


def test_what_is_left_of_a_dent_is_forgotten_where_nothing_shows_it():
    solve = solver()
    _, left = pressed_and_left(solve)
    assert dent_mm(left) > RECOVERED_MM
    state, steps = left, 0
    while not state.is_rest and steps < 20:
        state, steps = solve.solve(ball(1.0), state, dt_s=2.0), steps + 1
    assert 4 < steps < 20


def test_without_it_a_body_forgets_at_once():
    solve = solver(recovers=False)
    _, left = pressed_and_left(solve)
    assert left.is_rest


def test_friction_ends_with_the_contact():
    solve = solver(friction=1.0)
    sheared = solve.solve(ball(-0.8, 0.5), solve.solve(ball(-0.8), None, dt_s=0.05), dt_s=0.05)
    assert sheared.force_n[0] > 0.5
    left = solve.solve(ball(1.0, 0.5), sheared, dt_s=0.05)
    assert not left.force_n.any()
    assert not left.contact_traction_mpa.any()
    assert dent_mm(left) < 0.2 * dent_mm(sheared)
