"""Every option of the package against the plain NumPy statement of the same equations."""

import dataclasses

import cv2
import numpy as np
import pytest
from laboratory import plain_detectors as plain

from magicsim.detectors import DetectorProfile, detect, fuse
from magicsim.detectors.combined import judge
from magicsim.detectors.fusion import blur

from .conftest import grid_frame

OPTIONS = [
    {},
    {"polarity": "bright"},
    {"similarity": "iou"},
    {"similarity": "dice"},
    {"similarity": "iou", "polarity": "bright"},
    {"grid_reference": "majority"},
    {"grid_reference": "majority", "similarity": "dice"},
    {"grid_blur_px": 0},
    {"grid_blur_px": 3},
    {"grid_blur_px": 7},
    {"difference_blur_px": 3},
    {"difference_blur_px": 5},
    {"tau_b": 28},
    {"tau_b": 42},
    {"background_count": 1},
    {"background_count": 4},
    {"grey": "mean"},
    {"grey_rounding": "down"},
    {"grey": "mean", "grey_rounding": "down"},
    {"entropy_bins": 64},
    {"entropy_bins": 100},
    {"constant_channel": "skip"},
]


def sensor_frames(seed: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """References with noise and drift, and frames that brighten, darken, shift and saturate, channels unlike."""
    rng = np.random.default_rng(seed)
    unlike = np.array([1.0, 0.7, 0.5])

    def noisy(frame: np.ndarray) -> np.ndarray:
        return np.clip(np.rint(frame + rng.normal(0, 3, frame.shape)), 0, 255).astype(np.uint8)

    rest = grid_frame() * unlike
    references = [noisy(rest + 0.4 * number) for number in range(10)]
    rows, columns = np.indices(rest.shape[:2])
    spot = np.exp(-((rows - 20) ** 2 + (columns - 12) ** 2) / 80)[..., None]
    silent_blue = rest + spot * [60, 20, 0]
    silent_blue[..., 2] = 0
    frames = [
        noisy(rest),
        noisy(rest + spot * [80, 20, 50]),
        noisy(rest + 120 * spot),
        noisy(rest * 0.8),
        noisy(grid_frame(2) * unlike),
        noisy(rest * 4),
        silent_blue.astype(np.uint8),
    ]
    return references, frames


def options_of(profile: DetectorProfile) -> object:
    names = [each.name for each in dataclasses.fields(plain.PlainOptions)]
    return plain.PlainOptions(**{name: getattr(profile, name) for name in names})


@pytest.mark.parametrize("changed", OPTIONS, ids=str)
def test_features_and_verdicts_equal_the_plain_equations(changed):
    profile = DetectorProfile(reference_count=10, **changed)
    references, frames = sensor_frames(seed=5)
    options = options_of(profile)
    fused, expected_references = fuse(references, profile), plain.fuse(references, options)
    assert np.array_equal(fused.background.images, expected_references.backgrounds)
    for frame in frames:
        found, expected = detect(frame, fused, profile), plain.detect(frame, expected_references, options)
        # OpenCV's luma has binary weights, so a level near a half may round the other way.
        close = 0.02 if (profile.grey, profile.grey_rounding) == ("luma", "nearest") else 1e-12
        assert found.entropy == pytest.approx(expected[0], abs=close)
        assert found.correlation == pytest.approx(expected[1], abs=1e-12)
        assert found.similarity == pytest.approx(expected[2], abs=1e-12)
        words = plain.verdicts(found.entropy, found.correlation, found.similarity, options)
        assert (found.proximity, found.contact, found.combined) == words


def test_every_option_that_is_listed_changes_a_feature():
    """An option that the package ignored would pass the comparison only if the frames did not tell it apart."""
    references, frames = sensor_frames(seed=5)
    standard = DetectorProfile(reference_count=10)
    fused = fuse(references, standard)
    before = [detect(frame, fused, standard) for frame in frames]
    for changed in OPTIONS[1:]:
        profile = dataclasses.replace(standard, **changed)
        fused = fuse(references, profile)
        assert [detect(frame, fused, profile) for frame in frames] != before, changed


def test_verdicts_at_and_beside_every_threshold_equal_the_plain_ones():
    profile = DetectorProfile()
    options = options_of(profile)
    for e in (0.0, np.nextafter(0.5, 0), 0.5, 0.6, 7.0):
        for c in (-1.0, np.nextafter(0.2, 0), 0.2, 0.24, 1.0):
            for s in (0.0, np.nextafter(0.6, 0), 0.6, 0.72, 1.0):
                found = judge(entropy=float(e), correlation=float(c), similarity=float(s), profile=profile)
                assert (found.proximity, found.contact, found.combined) == plain.verdicts(e, c, s, options)


@pytest.mark.parametrize("size", [3, 5, 7])
def test_kernels_without_sigma_are_the_whole_number_gaussians(size):
    image = np.random.default_rng(size).integers(0, 256, (23, 17, 3), dtype=np.uint8)
    assert np.array_equal(blur(image, size), plain.gaussian_blur(image, size, 0.0))


@pytest.mark.parametrize(("size", "sigma"), [(9, 0.0), (11, 0.0), (5, 0.7), (5, 3.0), (21, 2.0)])
def test_kernels_with_sigma_follow_the_gaussian_within_rounding(size, sigma):
    """OpenCV keeps the weights in 2^-8, which moves a pixel by one level at most."""
    image = np.random.default_rng(size).integers(0, 256, (23, 19, 3), dtype=np.uint8)
    difference = blur(image, size, sigma).astype(int) - plain.gaussian_blur(image, size, sigma)
    assert np.abs(difference).max() <= 1


def test_number_of_threads_changes_nothing():
    references, frames = sensor_frames(seed=6)
    profile = DetectorProfile(reference_count=10)
    threads = cv2.getNumThreads()
    try:
        found = []
        for count in (1, 4):
            cv2.setNumThreads(count)
            fused = fuse(references, profile)
            found.append([detect(frame, fused, profile) for frame in frames])
    finally:
        cv2.setNumThreads(threads)
    assert found[0] == found[1]
