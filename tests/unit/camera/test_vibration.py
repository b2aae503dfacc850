import numpy as np
import pytest

from magicsim.camera.disturbances import shift_px, shifted


def wave(down: float, across: float, frequency: float) -> np.ndarray:
    row, column = np.indices((64, 48), float)
    found = 2 + np.sin(frequency * (row - down) + 0.3) + np.cos(0.7 * frequency * (column - across))
    return np.repeat(found[..., None], 3, 2).astype(np.float32)


def missed(by: tuple[float, float], frequency: float) -> float:
    """Largest error away from the borders."""
    found = shifted(wave(0, 0, frequency), np.array(by)) - wave(*by, frequency)
    return float(np.abs(found[8:-8, 8:-8]).max())


@pytest.mark.parametrize("by", [(0.02, 0.0), (0.0, -0.3), (0.25, 0.4), (-2.4, 3.0)])
def test_a_wave_is_seen_where_it_was_moved_to(by: tuple[float, float]):
    """Cubic convolution errs with the third power of the frequency at least."""
    assert missed(by, 0.5) < 6e-3
    assert missed(by, 0.25) < missed(by, 0.5) / 7


def test_no_shift_changes_nothing_and_an_even_image_stays():
    assert (shifted(wave(0, 0, 0.5), np.zeros(2)) == wave(0, 0, 0.5)).all()
    even = np.full((20, 30, 3), 0.7, np.float32)
    assert shifted(even, np.array([0.3, -0.2])) == pytest.approx(even, abs=1e-6)


def test_shifts_have_the_deviation_asked_for_and_know_nothing_of_each_other():
    found = np.array([shift_px(0.05, seed=4, frame=frame) for frame in range(4000)])
    assert found.std(0) == pytest.approx([0.05, 0.05], rel=0.05)
    assert abs(np.corrcoef(found[:-1, 0], found[1:, 0])[0, 1]) < 0.06
    assert abs(np.corrcoef(found.T)[0, 1]) < 0.06
    assert (shift_px(0.05, seed=4, frame=7) == found[7]).all()
    assert (shift_px(0.05, seed=5, frame=7) != found[7]).all()
