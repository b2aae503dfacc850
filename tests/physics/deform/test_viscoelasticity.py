"""Rate dependence against closed forms: linear viscoelasticity, transient network in finite shear, a held sphere."""

from collections.abc import Sequence

import numpy as np
import pytest
from laboratory.stress.cases import jittered

from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS
from magicsim.deform.lattice.relaxation import FULL, Branches, Relaxation, RelaxationState
from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.plain import SphereObject

MU, LAME = 0.4, 9.0
TIMES_S, MODULI = np.array([0.05, 0.8]), np.array([1.5, 0.7])
LATTICE = jittered(
    box_lattice(
        (np.array([-1.0, -0.4, 0.5]), np.array([-1.0, 0.2, 1.0]), np.array([0.0, 0.3, 1.1])),
        shear_modulus_mpa=MU,
        lame_mpa=LAME,
    ),
    share=0.2,
    seed=0,
)
ELASTICITY = Elasticity.of(LATTICE)
BRANCHES = Branches(times_s=TIMES_S, shear_modulus_mpa=np.tile(MODULI[:, None], len(LATTICE.cells)))
RELAXATION = Relaxation.of(ELASTICITY, BRANCHES)
SHEAR = np.array([[0.0, 0.0, 1.0], [0, 0, 0], [0, 0, 0]])
UNIAXIAL = np.diag([0.0, 0.0, 1.0])
SMALL = 1e-6


def stresses(gradients: Sequence[np.ndarray], steps_s: Sequence[float]) -> np.ndarray:
    """Mean Cauchy stress at the end of each step of a homogeneous motion, shape (steps, 3, 3)."""
    state, found = RELAXATION.rest(), []
    for gradient, dt_s in zip(gradients, steps_s, strict=True):
        positions = LATTICE.nodes_mm @ gradient.T
        forces = RELAXATION.timed_elasticity(state, dt_s=dt_s).evaluate(positions).gradient
        nominal = forces.T @ LATTICE.nodes_mm / ELASTICITY.volumes.sum()
        found.append(nominal @ gradient.T / np.linalg.det(gradient))
        state = RELAXATION.advanced(state, positions, dt_s=dt_s)
    return np.array(found)


def motion(mode: np.ndarray, size: np.ndarray) -> list[np.ndarray]:
    return [np.eye(3) + value * mode for value in size]


@pytest.mark.parametrize(("mode", "factor", "held"), [(SHEAR, 1, 0.0), (UNIAXIAL, 2, LAME)], ids=["shear", "uniaxial"])
def test_small_ramp_and_hold_is_the_hereditary_integral(mode: np.ndarray, factor: int, held: float) -> None:
    """Ramp of 0.4 s, then hold; strain is linear between the steps, so the step's length does not matter."""
    ends = np.array([0.1, 0.15, 0.4, 0.401, 0.5, 2.0, 6.0])
    steps, strain = np.diff(ends, prepend=0), SMALL * np.minimum(ends / 0.4, 1)
    row, column = np.argwhere(mode)[0]
    measured = stresses(motion(mode, strain), steps)[:, row, column]
    ramped = np.minimum(ends, 0.4)[:, None]
    passed = np.exp(-(ends[:, None] - ramped) / TIMES_S) - np.exp(-ends[:, None] / TIMES_S)
    expected = (held + factor * MU) * strain + factor * SMALL / 0.4 * passed @ (MODULI * TIMES_S)
    np.testing.assert_allclose(measured, expected, rtol=2e-5)


@pytest.mark.parametrize("angular", [0.5, 4.0, 30.0])
def test_small_oscillation_has_the_storage_and_loss_moduli_of_the_series(angular: float) -> None:
    period = 2 * np.pi / angular
    dt_s = period / 120
    count = 120 * (1 + int(np.ceil(8 * TIMES_S.max() / period)))
    phase = angular * dt_s * np.arange(1, count + 1)
    measured = stresses(motion(SHEAR, SMALL * np.sin(phase)), [dt_s] * count)[-120:, 0, 2] / SMALL
    storage, loss = (2 * np.mean(measured * wave(phase[-120:])) for wave in (np.sin, np.cos))
    x = angular * TIMES_S
    assert storage == pytest.approx(MU + (MODULI * x**2 / (1 + x**2)).sum(), rel=2e-3)
    assert loss == pytest.approx((MODULI * x / (1 + x**2)).sum(), rel=5e-3)


def test_error_of_a_small_oscillation_is_of_second_order_in_the_step() -> None:
    angular, end = 7.0, 1.0
    x = angular * TIMES_S
    waves = x * np.sin(angular * end) + np.cos(angular * end) - np.exp(-end / TIMES_S)
    expected = MU * np.sin(angular * end) + (MODULI * x / (1 + x**2) * waves).sum()
    errors = []
    for count in (20, 40, 80):
        strain = SMALL * np.sin(angular * end * np.arange(1, count + 1) / count)
        errors.append(abs(stresses(motion(SHEAR, strain), [end / count] * count)[-1, 0, 2] / SMALL - expected))
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(slopes, 2, atol=0.1)


def test_finite_shear_step_decays_as_the_transient_network() -> None:
    """Sigma = mu_inf (b - 1) + sum mu_i e^(-t/tau_i) (b - 1), whatever the steps of the hold."""
    gradient = np.eye(3) + 0.8 * SHEAR
    steps = np.array([0.0, 0.01, 0.09, 0.4, 3.0])
    modulus = MU + np.exp(-np.cumsum(steps)[:, None] / TIMES_S) @ MODULI
    measured = stresses([gradient] * 5, steps)
    np.testing.assert_allclose(measured, modulus[:, None, None] * (gradient @ gradient.T - np.eye(3)), atol=1e-12)


def test_networks_after_a_finite_shear_step_are_partly_renewed() -> None:
    gradient = np.eye(3) + 0.8 * SHEAR
    state = RELAXATION.rest()
    for dt_s in (0.0, 0.1, 0.2):
        state = RELAXATION.advanced(state, LATTICE.nodes_mm @ gradient.T, dt_s=dt_s)
    kept = np.exp(-0.3 / TIMES_S)[:, None, None, None, None]
    expected = kept * np.eye(3) + (1 - kept) * np.linalg.inv(gradient.T @ gradient)
    np.testing.assert_allclose(state.tensors[..., FULL], np.broadcast_to(expected, (2, 8, 8, 3, 3)), atol=1e-12)


def test_start_up_of_finite_shear_has_the_normal_stress_of_the_transient_network() -> None:
    """At a constant rate sigma_xz = sum mu rate tau (1 - e^-x), N1 = sum 2 mu (rate tau)^2 (1 - e^-x (1 + x))."""
    end, rate = 0.5, 2.0
    x = end / TIMES_S
    shear = MU * rate * end + (MODULI * rate * TIMES_S * -np.expm1(-x)).sum()
    normal = MU * (rate * end) ** 2 + (2 * MODULI * (rate * TIMES_S) ** 2 * (1 - np.exp(-x) * (1 + x))).sum()
    errors = []
    for count in (10, 20, 40):
        last = stresses(motion(SHEAR, rate * end * np.arange(1, count + 1) / count), [end / count] * count)[-1]
        assert last[0, 2] == pytest.approx(shear, rel=1e-10)
        errors.append(abs(last[0, 0] - last[2, 2] - normal))
    assert errors[-1] < 0.01 * normal
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.1)


def free_energy_and_loss(positions: np.ndarray, state: RelaxationState) -> tuple[float, float]:
    """Stored energy, long-term lattice included [N mm], and the rate at which it is lost [N mm/s]."""
    corners = positions[LATTICE.cells]
    f = np.einsum("cpi,qpk,cqkl->cqil", corners, GAUSS_GRADIENTS, ELASTICITY.inverse)
    elastic = ELASTICITY.evaluate(positions)
    stored = elastic.energy_mj + (LAME / 2 * ELASTICITY.volumes * (elastic.jacobian - 1) ** 2).sum()
    lost = 0.0
    for modulus, time, tensor in zip(MODULI, TIMES_S, state.tensors[..., FULL], strict=True):
        carried = f @ tensor @ f.transpose(0, 1, 3, 2)
        trace, back = (np.trace(each, axis1=2, axis2=3) for each in (carried, np.linalg.inv(carried)))
        stored += modulus / 2 * (ELASTICITY.weights * (trace - 3 - np.log(np.linalg.det(carried)))).sum()
        rate = modulus / (2 * time) * (trace + back - 6)
        assert (rate >= -1e-12).all()
        lost += (ELASTICITY.weights * rate).sum()
    return stored, lost


def unbalanced_work(count: int) -> tuple[float, float]:
    """Work less stored energy and loss along a smooth uneven motion of 0.6 s in so many steps; and the loss."""
    rng, dt_s = np.random.default_rng(5), 0.6 / count
    first, second = 0.05 * rng.normal(size=(2, *LATTICE.nodes_mm.shape))
    state, before = RELAXATION.rest(), LATTICE.nodes_mm
    force, (stored, rate), balance, loss = np.zeros_like(before), (0.0, 0.0), 0.0, 0.0
    for step in range(1, count + 1):
        angle = 2 * np.pi * step / count
        after = LATTICE.nodes_mm + np.sin(angle) * first + (1 - np.cos(angle)) * second
        next_force = RELAXATION.timed_elasticity(state, dt_s=dt_s).evaluate(after).gradient
        state = RELAXATION.advanced(state, after, dt_s=dt_s)
        next_stored, next_rate = free_energy_and_loss(after, state)
        own_loss = (rate + next_rate) / 2 * dt_s
        balance += ((force + next_force) / 2 * (after - before)).sum() - (next_stored - stored) - own_loss
        loss += own_loss
        before, force, stored, rate = after, next_force, next_stored, next_rate
    return balance, loss


def test_work_is_stored_or_lost_and_the_loss_is_never_negative() -> None:
    (coarse, _), (fine, loss) = unbalanced_work(60), unbalanced_work(120)
    assert loss > 0
    assert abs(fine) < 0.01 * loss
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.15)


def test_force_of_a_held_sphere_relaxes_as_the_modulus() -> None:
    """Incompressible and small: the shape stays, so the force follows mu_inf + sum mu_i e^(-t/tau_i)."""
    across = np.linspace(-4, 4, 9)
    lattice = box_lattice((across, across, np.linspace(0, 4, 5)), shear_modulus_mpa=MU, lame_mpa=5e3 * MU)
    branches = Branches(times_s=TIMES_S, shear_modulus_mpa=np.tile(MODULI[:, None], len(lattice.cells)))
    solver = ContactSolver(lattice, tolerance_mm=1e-5, branches=branches)
    pose = place_object(SphereObject(kind="sphere", radius_mm=4.0), gap_mm=-0.3)
    long_term = ContactSolver(lattice, tolerance_mm=1e-5).solve(pose).force_n[2]
    held, forces = None, []
    steps = np.array([0.0, 0.03, 0.1, 0.6, 8.0])
    for dt_s in steps:
        held = solver.solve(pose, held, dt_s=dt_s)
        forces.append(held.force_n[2])
    modulus = MU + np.exp(-np.cumsum(steps)[:, None] / TIMES_S) @ MODULI
    np.testing.assert_allclose(forces / long_term, modulus / MU, rtol=0.005)
    assert forces[-1] == pytest.approx(long_term, rel=1e-3)
