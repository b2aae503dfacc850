"""Orientation, part, size and order of colours of frames."""

import numpy as np
import pytest

from magicsim.dataset.real.description import FrameForm
from magicsim.dataset.real.form import brightened, formed
from magicsim.detectors.orientation import TURNS, after, turned
from magicsim.errors import FrameError

from .drawn import COLUMNS, ROWS, untouched


def test_no_form_changes_nothing():
    assert np.array_equal(formed(untouched(), FrameForm()), untouched())


def test_turn_is_counter_clockwise_and_mirrors_after_it():
    frame = untouched()
    assert np.array_equal(formed(frame, FrameForm(rotate_deg=90))[-1, 0], frame[0, 0])  # top left to bottom left
    assert np.array_equal(formed(frame, FrameForm(rotate_deg=90, mirror=True))[-1, -1], frame[0, 0])


def test_colours_part_and_size_come_in_their_order():
    frame = untouched()
    found = formed(frame, FrameForm(color_order="bgr", crop_px=(8, 4, 40, 20), rotate_deg=180, size_px=(20, 10)))
    assert found.shape == (10, 20, 3)
    part = frame[4:24, 8:48, ::-1].astype(float)[::-1, ::-1]
    assert found == pytest.approx(part.reshape(10, 2, 20, 2, 3).mean((1, 3)), abs=0.51)


def test_every_two_turns_are_one():
    frame = untouched()
    for first in TURNS:
        for then in TURNS:
            assert np.array_equal(turned(turned(frame, first), then), turned(frame, after(first, then)))


def test_gain_is_cut_off_at_white():
    assert brightened(np.full((2, 2, 3), 100, np.uint8), 1.255).tolist() == np.full((2, 2, 3), 126).tolist()
    assert brightened(np.full((1, 1, 3), 200, np.uint8), 2.0).max() == 255


def test_part_outside_of_the_frame_is_refused():
    with pytest.raises(
        FrameError, match=rf"frames.crop_px = .* must lie inside of 'a.png', which has {COLUMNS} x {ROWS}"
    ):
        formed(untouched(), FrameForm(crop_px=(60, 0, 40, 20)), name="a.png")
