import numpy as np
import pytest

from magicsim.camera.disturbances import led_drift
from magicsim.camera.effect_settings import LedDrift

DRIFT = LedDrift(share=0.01, time_s=20.0)
SEEDS = 3000


@pytest.fixture(scope="module")
def wander() -> np.ndarray:
    """At 0, 5, 20 and 60 s, shape (seeds, times, 3)."""
    return np.array([[led_drift(DRIFT, time_s=t, seed=seed) for t in (0, 5, 20, 60)] for seed in range(SEEDS)])


def test_its_size_is_the_share_at_all_times(wander: np.ndarray):
    assert wander.std(0) == pytest.approx(np.full((4, 3), 0.01), rel=0.06)
    assert np.abs(wander.mean(0)).max() < 4 * 0.01 / np.sqrt(SEEDS)


@pytest.mark.parametrize(("place", "time_s"), [(1, 5.0), (2, 20.0), (3, 60.0)])
def test_its_correlation_falls_exponentially_with_time(wander: np.ndarray, place: int, time_s: float):
    found = (wander[:, 0] * wander[:, place]).mean() / 0.01**2
    assert found == pytest.approx(np.exp(-time_s / 20.0), abs=5 / np.sqrt(3 * SEEDS))


def test_colours_wander_by_themselves(wander: np.ndarray):
    correlation = np.corrcoef(wander[:, 0].T)
    assert np.abs(correlation[~np.eye(3, dtype=bool)]).max() < 5 / np.sqrt(SEEDS)
