import numpy as np
import pytest

from magicsim.camera.camera import Camera
from magicsim.camera.disturbances import dark_signal_e, is_alive, row_offsets_e
from magicsim.camera.effect_settings import PixelFaults

SIZE = {"rows": 300, "columns": 200}


def dark(faults: PixelFaults, seed: int = 0) -> np.ndarray:
    return dark_signal_e(Camera(faults=faults, **SIZE, pattern_seed=seed))


def test_dark_signals_have_their_deviation_and_belong_to_the_camera():
    found = dark(PixelFaults(dark_e=7.0))
    assert found.std() == pytest.approx(7.0, rel=0.01)
    assert found.mean() == pytest.approx(0, abs=0.1)
    assert (dark(PixelFaults(dark_e=7.0), 0) == found).all()
    assert abs(np.corrcoef(dark(PixelFaults(dark_e=7.0), 1).ravel(), found.ravel())[0, 1]) < 0.01


def test_hot_pixels_are_as_many_and_as_hot_as_said():
    found = dark(PixelFaults(hot_share=0.01, hot_e=500.0))
    hot = found[found > 0]
    assert hot.size / found.size == pytest.approx(0.01, rel=0.15)
    assert hot.mean() == pytest.approx(500, rel=0.15)
    assert np.median(hot) == pytest.approx(500 * np.log(2), rel=0.2)


def test_dead_pixels_are_as_many_as_said():
    alive = is_alive(Camera(faults=PixelFaults(dead_share=0.02), **SIZE, pattern_seed=3))
    assert 1 - alive.mean() == pytest.approx(0.02, rel=0.1)


def test_a_row_has_one_offset_in_a_frame_and_another_in_the_next():
    first, second = (row_offsets_e(PixelFaults(row_e=3.0), rows=4000, seed=1, frame=frame) for frame in (5, 6))
    assert first.shape == (4000, 1, 1)
    assert first.std() == pytest.approx(3.0, rel=0.05)
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.06
