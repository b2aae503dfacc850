import numpy as np
import pytest

from magicsim.camera.disturbances import between_frames, readout_problem
from magicsim.camera.effect_settings import Shutter

RATE = 20.0


def ramp(at: float) -> np.ndarray:
    """A brightness that grows along columns and with time."""
    column = np.arange(12, dtype=float)
    return np.broadcast_to((column + at)[None, :, None], (10, 12, 3)).astype(np.float32)


def test_rows_show_a_ramp_that_moves_evenly_where_it_was_in_the_middle_of_their_exposure():
    shutter, speed = Shutter(exposure_ms=8.0, row_us=2000.0, moves=True), 30.0  # levels a second
    found = between_frames(ramp(0.0), ramp(speed / RATE), shutter, frames_per_second=RATE)
    ends = 1 / RATE - 2e-3 * np.arange(9, -1, -1)
    expected = np.arange(12) + speed * (ends - 4e-3)[:, None]
    assert found[..., 0] == pytest.approx(expected, abs=1e-5)


def test_a_short_global_shutter_shows_this_frame_alone():
    found = between_frames(ramp(0.0), ramp(7.0), Shutter(exposure_ms=1e-6), frames_per_second=RATE)
    assert found == pytest.approx(ramp(7.0), abs=1e-4)


def test_no_row_shows_more_than_the_two_frames():
    shutter = Shutter(exposure_ms=50.0, row_us=5000.0)
    found = between_frames(ramp(0.0), ramp(1.0), shutter, frames_per_second=RATE)
    assert (found >= ramp(0.0)).all()
    assert (found <= ramp(1.0)).all()


def test_what_stands_still_is_seen_as_it_is():
    still = between_frames(ramp(2.0), ramp(2.0), Shutter(row_us=1000.0), frames_per_second=RATE)
    assert (still == ramp(2.0)).all()


def test_rows_have_to_be_read_between_frames():
    assert readout_problem(Shutter(row_us=50.0), rows=1000, frames_per_second=20.0) is None
    line = readout_problem(Shutter(row_us=51.0), rows=1000, frames_per_second=20.0)
    assert line is not None
    assert "row_us = 51 is not allowed: 1000 rows are read in 51 ms, which must be at most the 50 ms" in line
