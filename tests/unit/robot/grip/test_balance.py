from collections.abc import Callable

import numpy as np
import pytest

from magicsim.errors import ConvergenceError
from magicsim.robot.grip.held import find_balance

WIDE = {"tolerance_n": 1e-3, "most_mm": 3.0, "low": np.full(3, -9.0), "high": np.full(3, 9.0)}


def spring(load: np.ndarray, matrix: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    return lambda place: load - matrix @ place


def test_linear_body_comes_to_rest_where_its_stiffness_says_though_the_estimate_is_wrong():
    matrix = np.array([[4.0, 1.0, 0.0], [-1.0, 3.0, 0.5], [0.0, 0.5, 2.0]])  # not symmetric, as friction is
    load = np.array([1.0, -0.5, 0.3])
    tried: list[np.ndarray] = []

    def unbalanced(place: np.ndarray) -> np.ndarray:
        tried.append(place)
        return spring(load, matrix)(place)

    found = find_balance(unbalanced, 5 * np.eye(3), **WIDE, keep=lambda: None)
    assert found.is_balanced
    np.testing.assert_allclose(found.place, np.linalg.solve(matrix, load), atol=2e-3)
    assert len(tried) < 15


def test_coordinate_without_a_range_is_held():
    limits = WIDE | {"low": np.array([-9.0, 0.0, -9.0]), "high": np.array([9.0, 0.0, 9.0])}
    found = find_balance(spring(np.ones(3), 2 * np.eye(3)), 2 * np.eye(3), **limits, keep=lambda: None)
    assert found.is_balanced
    assert found.place == pytest.approx([0.5, 0, 0.5])


@pytest.mark.parametrize(("pull", "is_held"), [(0.9, True), (1.1, False)])
def test_body_held_by_friction_is_lost_above_its_bound(pull: float, is_held: bool):
    kept = []

    def unbalanced(place: np.ndarray) -> np.ndarray:
        return np.array([pull - np.clip(5 * place[0], -1, 1), 0, 0])

    found = find_balance(unbalanced, 5 * np.eye(3), **WIDE, keep=lambda: kept.append(1))
    assert found.is_balanced is is_held
    assert found.limit is None
    assert bool(kept) is not is_held


def test_failing_trial_is_tried_again_nearer():
    def unbalanced(place: np.ndarray) -> np.ndarray:
        if abs(place[0]) > 0.3:
            msg = "too far"
            raise ConvergenceError(msg)
        return np.array([0.25 - place[0], 0, 0])

    found = find_balance(unbalanced, np.diag([0.4, 1, 1]), **WIDE, keep=lambda: None)
    assert found.place[0] == pytest.approx(0.25, abs=2e-3)


def test_restless_body_is_an_error_with_figures():
    random, wide = np.random.default_rng(0), np.full(3, 99.0)
    limits = {"tolerance_n": 1e-3, "most_mm": 99, "low": -wide, "high": wide}
    with pytest.raises(ConvergenceError, match=r"does not come to rest: .* N out of balance after 4\d trials"):
        find_balance(lambda _: random.choice([-1.0, 1.0], 3), 5 * np.eye(3), **limits, keep=lambda: None)
