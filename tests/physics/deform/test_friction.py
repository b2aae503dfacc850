"""Coulomb friction: its law, its potential, stick and slip under shear and twist, release."""

import numpy as np
import pytest

from magicsim.deform.contact.augmented import evaluate_contact
from magicsim.deform.contact.face import contact_face
from magicsim.deform.contact.friction import ContactLaw, ContactMemory, stick_stiffness, updated_limits
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.structure import Lattice, box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import load_design
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")


def small_block() -> Lattice:
    across = np.linspace(-4, 4, 9)
    return box_lattice((across, across, np.linspace(0, 4, 5)), shear_modulus_mpa=1 / 3, lame_mpa=10.0)


def path(friction: float, *poses: dict[str, float]) -> list[Deformation]:
    solver, states = ContactSolver(small_block(), friction=friction), []
    for pose in poses:
        states.append(solver.solve(place_object(BALL, **pose), states[-1] if states else None))
    return states


def coulomb_excess(state: Deformation, friction: float) -> float:
    """Largest tangential traction beyond mu times the pressure, over the largest pressure."""
    pressure = state.contact_pressure_mpa
    total = np.linalg.norm(state.contact_traction_mpa, axis=1)
    tangential = np.sqrt(np.maximum(total**2 - pressure**2, 0))
    return float((tangential - friction * pressure).max() / pressure.max())


def test_tractions_derive_from_the_energy_with_frozen_limits() -> None:
    lattice = small_block()
    face, rng = contact_face(lattice), np.random.default_rng(0)
    surface = place_object(BALL, gap_mm=-0.6).distance
    points = face.positions(lattice.nodes_mm)
    memory = ContactMemory(
        multipliers_mpa=rng.uniform(0, 0.3, len(points)),
        penalty=60.0,
        anchors_mm=points + rng.normal(size=points.shape) * 0.004,
        limit_mpa=rng.uniform(0, 0.5, len(points)),
        normal=surface(points)[1],
    )
    law = ContactLaw(slip_penalty=40.0, friction=0.5)
    nodes = lattice.nodes_mm + 0.002 * rng.normal(size=lattice.nodes_mm.shape)
    assert surface(points)[0].min() < 0
    direction, step = rng.normal(size=nodes.shape), 1e-7
    energies = [evaluate_contact(face, nodes + s * step * direction, surface, memory, law).energy_mj for s in (1, -1)]
    force = evaluate_contact(face, nodes, surface, memory, law).node_force_n
    assert -(energies[0] - energies[1]) / (2 * step) == pytest.approx((force * direction).sum(), rel=1e-5)


def test_full_slip_pulls_with_the_coefficient_of_friction() -> None:
    pressed, slid = path(0.1, {"gap_mm": -0.5}, {"gap_mm": -0.5, "x_mm": 1.0})
    assert slid.is_slipping.sum() == (slid.contact_pressure_mpa > 0).sum()
    assert slid.force_n[0] == pytest.approx(0.1 * slid.force_n[2], rel=0.12)
    assert pressed.force_n[0] == pytest.approx(0, abs=1e-8)
    assert coulomb_excess(slid, 0.1) < 1e-2


def test_a_small_shear_sticks_and_is_carried_by_the_block() -> None:
    pressed, sheared, doubled = path(
        2.0, {"gap_mm": -0.5}, {"gap_mm": -0.5, "x_mm": 0.02}, {"gap_mm": -0.5, "x_mm": 0.04}
    )
    assert not sheared.is_slipping[sheared.contact_pressure_mpa > 0.05].any()
    first, second = sheared.force_n[0] - pressed.force_n[0], doubled.force_n[0] - sheared.force_n[0]
    assert first > 0
    assert second == pytest.approx(first, rel=0.05)


def test_friction_forgets_nothing_on_the_way_back() -> None:
    """Shear out and back leaves a tangential force of the other sign: slip is not reversible."""
    states = path(0.2, {"gap_mm": -0.5}, {"gap_mm": -0.5, "x_mm": 0.8}, {"gap_mm": -0.5, "x_mm": 0.0})
    assert states[1].force_n[0] > 0.05
    assert states[2].force_n[0] < -0.05


def test_twist_turns_the_sensor_with_the_object_up_to_the_limit() -> None:
    states = path(0.2, {"gap_mm": -0.5}, *({"gap_mm": -0.5, "twist_deg": angle} for angle in (5.0, 30.0, 60.0)))
    torque = [state.torque_nmm[2] for state in states]
    assert 0 <= abs(torque[0]) < 1e-6
    assert 0 < torque[1] < torque[2]
    assert torque[3] == pytest.approx(torque[2], rel=0.05)
    for state in states[1:]:
        assert abs(state.force_n[0]) < 1e-2 * state.force_n[2]


def test_release_leaves_nothing_behind() -> None:
    solver = ContactSolver(small_block(), friction=0.5)
    state = solver.solve(place_object(BALL, gap_mm=-0.5))
    state = solver.solve(place_object(BALL, gap_mm=-0.5, x_mm=0.5), state)
    state = solver.solve(place_object(BALL, gap_mm=0.1, x_mm=0.5), state)
    assert state.is_rest
    np.testing.assert_array_equal(state.force_n, 0)


def test_friction_makes_a_press_stiffer() -> None:
    forces = [path(friction, {"gap_mm": -0.8})[0].force_n[2] for friction in (0.0, 1.0)]
    assert forces[0] < forces[1] < 1.2 * forces[0]


def test_forces_balance_under_shear_and_twist() -> None:
    for state in path(0.6, {"gap_mm": -0.6}, {"gap_mm": -0.6, "x_mm": 0.5}, {"gap_mm": -0.6, "twist_deg": 45.0}):
        assert state.force_balance < 1e-6
        assert state.max_penetration_mm <= 0.002
        assert state.min_jacobian > 0


def memory_of(limits: list[float]) -> ContactMemory:
    count = len(limits)
    return ContactMemory(
        multipliers_mpa=np.zeros(count),
        penalty=60.0,
        anchors_mm=np.zeros((count, 3)),
        limit_mpa=np.array(limits),
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
    )


def test_a_point_reaches_its_limit_after_the_elastic_slip_or_what_its_stiffness_needs() -> None:
    law = ContactLaw(slip_penalty=40.0, elastic_slip_mm=0.01, friction=1.0)
    stiffness = stick_stiffness(memory_of([0.1, 0.8, 0.0]), law)
    np.testing.assert_allclose(stiffness, [10.0, 40.0, 0.0])


def test_relaxed_limits_settle_where_chasing_ones_would_run_away() -> None:
    """Pressures that answer limits linearly with a slope of -1.5: the fixed point is met by the second relaxation."""
    law, memory = ContactLaw(slip_penalty=40.0, friction=1.0), memory_of([0.0, 0.0])
    for _ in range(3):
        pressure = np.array([1.0, 2.0]) - 1.5 * memory.limit_mpa
        memory = updated_limits(memory, pressure, memory.normal, law, is_relaxed=True)
    np.testing.assert_allclose(memory.limit_mpa, [0.4, 0.8], rtol=1e-9)


def test_turns_of_half_a_circle_and_more_pull_the_way_they_go():
    block = load_design("uniform-block", ["footprint_mm=[8,8]", "lattice.spacing_mm=1.0"])
    slid, more = (press(block, BALL, depth_mm=0.6, twist_deg=turn, friction=0.6) for turn in (180.0, 270.0))
    assert slid.torque_nmm[2] > 0.5
    assert more.torque_nmm[2] == pytest.approx(slid.torque_nmm[2], rel=0.02)
    assert [each.twist_deg for each in more.history] == [0.0, 90.0, 180.0, 270.0]
