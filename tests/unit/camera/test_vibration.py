import numpy as np
import pytest

from magicsim.camera.vibration import shift_px, shifted


@pytest.mark.parametrize("by", [(0.02, 0.0), (0.0, -0.3), (0.25, 0.4)])
def test_a_wave_is_seen_where_it_was_moved_to(by: tuple[float, float]):
    row, column = np.indices((64, 48), float)

    def wave(down: float, across: float) -> np.ndarray:
        found = 2 + np.sin(0.5 * (row - down) + 0.3) + np.cos(0.35 * (column - across))
        return np.repeat(found[..., None], 3, 2).astype(np.float32)

    found = shifted(wave(0, 0), np.array(by))
    inside = (slice(8, -8), slice(8, -8))
    assert found[inside] == pytest.approx(wave(*by)[inside], abs=2e-3)


def test_shifts_have_the_deviation_asked_for_and_know_nothing_of_each_other():
    found = np.array([shift_px(0.05, seed=4, frame=frame) for frame in range(4000)])
    assert found.std(0) == pytest.approx([0.05, 0.05], rel=0.05)
    assert abs(np.corrcoef(found[:-1, 0], found[1:, 0])[0, 1]) < 0.06
    assert abs(np.corrcoef(found.T)[0, 1]) < 0.06
    assert (shift_px(0.05, seed=4, frame=7) == found[7]).all()
    assert (shift_px(0.05, seed=5, frame=7) != found[7]).all()
