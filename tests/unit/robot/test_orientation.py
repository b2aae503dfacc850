import numpy as np

from magicsim.robot.capture import as_bgr, as_landscape

PORTRAIT = np.arange(4 * 3 * 3, dtype=np.uint8).reshape(4, 3, 3)


def test_channels_are_swapped_in_memory_of_their_own():
    swapped = as_bgr(PORTRAIT)
    assert (swapped[..., 0] == PORTRAIT[..., 2]).all()
    assert (swapped[..., 2] == PORTRAIT[..., 0]).all()
    assert swapped.flags.c_contiguous
    assert not np.shares_memory(swapped, PORTRAIT)


def test_landscape_is_turned_and_not_mirrored():
    turned = as_landscape(PORTRAIT)
    assert turned.shape == (3, 4, 3)
    assert (turned[0, -1] == PORTRAIT[0, 0]).all()  # the top left corner (-x, +y) goes to the top right
    assert (turned[0, 0] == PORTRAIT[-1, 0]).all()  # the bottom left one (-x, -y) to the top left
