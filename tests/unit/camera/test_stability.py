import numpy as np
import pytest

from magicsim.camera.effect_settings import correction_share, largest_share, least_frames


def errors(share: float, delay: int, frames: int = 4000) -> np.ndarray:
    """e(k + 1) = e(k) - a e(k - d), frame by frame."""
    found = [1.0] * (delay + 1)
    for _ in range(frames):
        found.append(found[-1] - share * found[-1 - delay])
    return np.abs(found)


@pytest.mark.parametrize("delay", range(6))
def test_errors_decay_below_the_bound_and_grow_above_it(delay: int):
    bound = largest_share(delay)
    assert errors(0.98 * bound, delay)[-50:].max() < 1e-3
    assert errors(1.02 * bound, delay)[-50:].max() > 1e3


@pytest.mark.parametrize("frames", [0.5, 3.0, 20.0])
def test_share_brings_the_error_to_one_over_e_in_the_time_constant(frames: float):
    assert (1 - correction_share(frames)) ** frames == pytest.approx(np.exp(-1))


@pytest.mark.parametrize("delay", [2, 3, 8])
def test_least_time_constant_has_the_largest_share(delay: int):
    assert correction_share(least_frames(delay)) == pytest.approx(largest_share(delay))


@pytest.mark.parametrize("delay", [0, 1])
def test_any_time_constant_settles_where_the_gain_arrives_soon(delay: int):
    assert least_frames(delay) == 0
