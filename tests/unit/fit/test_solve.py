import numpy as np
import pytest

from magicsim.fit.fitting import UNKNOWN_SD, deviations, differences, scatter, solve

PLACES = np.linspace(0, 1, 40)
TRUE = np.array([0.7, 0.2])


def curve(point: np.ndarray) -> np.ndarray:
    return np.exp(-3 * point[0] * PLACES) + point[1] ** 2 * PLACES


def residuals(point: np.ndarray) -> np.ndarray:
    return curve(point) - curve(TRUE)


def test_least_squares_are_found_from_every_start():
    found = solve(residuals, np.array([0.2, 0.9]), starts=3, evaluations=40, seed=1)
    assert found.point == pytest.approx(TRUE, abs=1e-3)
    assert found.ends == pytest.approx(np.tile(TRUE, (3, 1)), abs=5e-3)
    assert found.rms < 1e-4


def test_a_search_repeats_itself():
    runs = [solve(residuals, np.array([0.2, 0.9]), starts=2, evaluations=6, seed=4) for _ in range(2)]
    assert (runs[0].point == runs[1].point).all()
    assert runs[0].evaluations == runs[1].evaluations


def test_what_the_data_do_not_hold_stays_as_unknown_as_it_was():
    def blind(point: np.ndarray) -> np.ndarray:
        return np.append(residuals(point[:2]), 1e-9 * point[2]) + 1e-3 * np.sin(40 * np.arange(41))

    found = solve(blind, np.array([0.6, 0.3, 0.5]), starts=1, evaluations=30, seed=0)
    assert found.sd[2] == pytest.approx(UNKNOWN_SD, rel=1e-3)
    assert found.sd[:2].max() < 0.05
    assert np.abs(found.weakest) == pytest.approx([0, 0, 1], abs=1e-3)
    assert found.singular_values[-1] < 1e-6 < found.singular_values[1]


def test_deviation_is_that_of_repeated_fits_to_noisy_data():
    random, ends = np.random.default_rng(3), []
    jacobian = differences(residuals, TRUE)
    for _ in range(200):
        noise = random.normal(0, 0.01, len(PLACES))
        ends.append(np.linalg.lstsq(jacobian, noise, rcond=None)[0])
    noise = random.normal(0, 0.01, len(PLACES))
    assert deviations(jacobian, noise) == pytest.approx(np.std(ends, axis=0), rel=0.35)


def test_scatter_is_that_of_noise_which_all_residuals_share():
    """Noise along one direction of the data moves the fit by far more than its size in single residuals says."""
    random, jacobian = np.random.default_rng(5), differences(residuals, TRUE)
    common = [random.normal() * 0.01 * jacobian[:, 0] for _ in range(400)]
    assert scatter(jacobian, common)[0] == pytest.approx(0.01, rel=0.1)
    assert scatter(jacobian, common)[1] < 1e-3


def test_derivatives_stay_inside_the_cube():
    asked: list[np.ndarray] = []

    def watched(point: np.ndarray) -> np.ndarray:
        asked.append(point.copy())
        return residuals(point)

    differences(watched, np.array([0.0, 1.0]))
    assert all(((point >= 0) & (point <= 1)).all() for point in asked)
