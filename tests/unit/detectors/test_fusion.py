import dataclasses

import numpy as np
import pytest

from magicsim.detectors import DetectorProfile, fuse
from magicsim.detectors.fusion import fuse_background, fuse_grid
from magicsim.errors import FrameError

from .conftest import grid_frame


def flat(level: int) -> np.ndarray:
    return np.full((2, 2, 3), level, dtype=np.uint8)


def test_backgrounds_are_means_of_consecutive_runs():
    background = fuse_background([flat(level) for level in (10, 12, 30, 32, 20, 22)], count=3)
    assert background.images[:, 0, 0, 0].tolist() == [11, 31, 21]
    assert background.ceiling[1, 1].tolist() == [31, 31, 31]


def test_background_mean_rounds_halves_up():
    assert fuse_background([flat(1), flat(2)], count=1).images[0, 0, 0, 0] == 2
    assert fuse_background([flat(2), flat(3)], count=1).images[0, 0, 0, 0] == 3
    assert fuse_background([flat(1), flat(1), flat(2)], count=1).images[0, 0, 0, 0] == 1


def test_bright_frames_do_not_overflow():
    assert fuse_background([flat(255)] * 255, count=1).images.min() == 255
    assert fuse_grid([flat(255)] * 255, DetectorProfile(polarity="bright", grid_blur_px=0)).counts.min() == 255


def test_runs_cover_every_frame_when_the_count_does_not_divide():
    background = fuse_background([flat(level) for level in (0, 10, 20, 30)], count=3)
    assert background.images[:, 0, 0, 0].tolist() == [0, 10, 25]


def test_grid_presence_is_the_share_of_frames():
    frames = [flat(10), flat(10), flat(10), flat(90)]
    dark = fuse_grid(frames, DetectorProfile(polarity="dark", grid_blur_px=0))
    bright = fuse_grid(frames, DetectorProfile(polarity="bright", grid_blur_px=0))
    assert (dark.counts / dark.frames)[0, 0].tolist() == [0.75, 0.75, 0.75]
    assert (bright.counts / bright.frames)[0, 0].tolist() == [0.25, 0.25, 0.25]
    assert dark.areas == (12, 12, 12)


def test_only_the_first_reference_frames_count(profile):
    few = dataclasses.replace(profile, reference_count=3)
    later = np.full_like(grid_frame(), 255)
    references = fuse([grid_frame()] * 3 + [later] * 3, few)
    assert references.grid.frames == 3
    assert references.background.ceiling.max() == 80


def test_too_few_reference_frames_are_counted_in_the_error():
    with pytest.raises(FrameError, match=r"2 reference frame\(s\) .* background_count = 3"):
        fuse([grid_frame()] * 2, DetectorProfile())


def test_reference_frames_of_two_sizes_are_refused(profile):
    with pytest.raises(FrameError, match="like the reference"):
        fuse([grid_frame(), grid_frame(), grid_frame()[:-1]], profile)


def test_references_without_any_grid_are_refused(profile):
    with pytest.raises(FrameError, match=r"no pixel is at or below tau_b = 35"):
        fuse([np.full_like(grid_frame(), 90)] * 3, profile)


def test_blurs_of_the_profile_reach_both_references(profile):
    blurred = dataclasses.replace(profile, grid_blur_px=5, difference_blur_px=3)
    references = fuse([grid_frame()] * 3, blurred)
    assert (references.grid.blur_px, references.background.blur_px) == (5, 3)
    assert len(np.unique(references.background.ceiling)) > 2
    assert len(np.unique(fuse([grid_frame()] * 3, profile).background.ceiling)) == 2
