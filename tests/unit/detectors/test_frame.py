import numpy as np
import pytest

from magicsim.detectors import check_frame
from magicsim.errors import FrameError

GOOD = np.zeros((4, 5, 3), dtype=np.uint8)


def test_good_frame_passes_unchanged():
    frame = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    assert np.array_equal(check_frame(frame, shape=(4, 5, 3)), frame)


def test_flipped_view_becomes_contiguous_with_the_same_pixels():
    frame = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)[::-1, :, ::-1]
    checked = check_frame(frame)
    assert checked.flags.c_contiguous
    assert np.array_equal(checked, frame)


@pytest.mark.parametrize(
    ("frame", "named"),
    [
        (GOOD[..., 0], "(4, 5)"),
        (GOOD[..., :2], "(4, 5, 2)"),
        (GOOD[:0], "no pixels"),
        (GOOD[:, :0], "no pixels"),
        (GOOD.astype(np.uint16), "uint16"),
        (GOOD.astype(np.float32), "float32"),
        (np.full((4, 5, 3), np.nan), "60 NaN"),
        (np.where(np.arange(60).reshape(4, 5, 3) == 7, np.inf, 0.0), "1 NaN or infinite"),
        (GOOD.astype(bool), "bool"),
        (GOOD.astype(object), "object"),
        (7, "()"),
    ],
)
def test_unusable_frame_is_named_in_one_line(frame, named):
    with pytest.raises(FrameError) as caught:
        check_frame(frame)
    assert named in str(caught.value)
    assert "must " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_frame_of_another_size_names_both_sizes():
    with pytest.raises(FrameError, match=r"\(4, 5, 3\).*\(5, 5, 3\) like the reference"):
        check_frame(GOOD, shape=(5, 5, 3))
