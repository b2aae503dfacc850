import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from magicsim.detectors import DetectorProfile, Proximity
from magicsim.detectors.features import (
    brightening_correlation,
    brightening_entropy,
    decide_proximity,
    filter_channels,
)
from magicsim.detectors.fusion import BackgroundReference, fuse_background


def published_filter(frame: np.ndarray, backgrounds: np.ndarray) -> np.ndarray:
    """The published loop, channel by channel and word by word."""
    channels = []
    for channel in range(3):
        filtered = frame[..., channel].astype(int)
        for background in backgrounds[..., channel].astype(int):
            difference = np.maximum(frame[..., channel].astype(int) - background, 0)
            filtered = np.minimum(filtered, difference)
        channels.append(filtered)
    return np.stack(channels, axis=-1)


def published_entropy(filtered: np.ndarray) -> float:
    grey = np.floor(filtered @ np.array([0.299, 0.587, 0.114]) + 0.5).astype(int)
    shares = [np.mean(grey == level) for level in range(256)]
    return -sum(share * math.log2(share) for share in shares if share > 0)


def published_correlation(filtered: np.ndarray) -> float:
    values = []
    for one, other in itertools.combinations(np.moveaxis(filtered, -1, 0).reshape(3, -1).astype(float), 2):
        constant = one.std() == 0 or other.std() == 0
        values.append(0.0 if constant else np.corrcoef(one, other)[0, 1])
    return float(np.mean(values))


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), level=st.integers(1, 255), count=st.integers(1, 4))
def test_features_equal_the_published_loop(seed, level, count):
    rng = np.random.default_rng(seed)
    frames = rng.integers(0, level + 1, (count, 7, 5, 3), dtype=np.uint8)
    frame = rng.integers(0, 256, (7, 5, 3), dtype=np.uint8)
    filtered = filter_channels(frame, fuse_background(list(frames), count=count))
    assert np.array_equal(filtered, published_filter(frame, frames))
    assert brightening_correlation(filtered) == pytest.approx(published_correlation(filtered), abs=1e-9)
    # OpenCV's grey weights are binary fractions, so a grey level within 0.005 of a half may round otherwise.
    thousandths = filtered.astype(int) @ np.array([299, 587, 114])
    assume(np.abs(thousandths % 1000 - 500).min() > 5)
    assert brightening_entropy(filtered) == pytest.approx(published_entropy(filtered), abs=1e-9)


def test_only_pixels_that_brighten_against_every_background_count():
    backgrounds = np.array([[[[50, 50, 50]]], [[[60, 10, 55]]]], dtype=np.uint8)
    reference = BackgroundReference(images=backgrounds, ceiling=backgrounds.max(axis=0), blur_px=0)
    assert filter_channels(np.array([[[70, 40, 58]]], dtype=np.uint8), reference).tolist() == [[[10, 0, 3]]]


def test_blurred_reference_blurs_the_frame_too():
    flat = np.full((9, 9, 3), 20, dtype=np.uint8)
    point = flat.copy()
    point[4, 4] = 220
    assert filter_channels(point, fuse_background([flat], count=1, blur_px=0)).max() == 200
    assert 0 < filter_channels(point, fuse_background([flat], count=1, blur_px=5)).max() < 100


def test_entropy_of_four_equally_frequent_levels_is_two_bits():
    grey = np.array([[0, 10], [20, 30]], dtype=np.uint8)
    assert brightening_entropy(np.repeat(grey[..., None], 3, axis=2)) == pytest.approx(2.0, abs=1e-12)


def test_entropy_of_three_to_one_follows_the_formula():
    grey = np.array([[0, 0], [0, 9]], dtype=np.uint8)
    expected = -(0.75 * math.log2(0.75) + 0.25 * math.log2(0.25))
    assert brightening_entropy(np.repeat(grey[..., None], 3, axis=2)) == pytest.approx(expected, abs=1e-12)


def test_entropy_of_one_level_is_zero():
    assert brightening_entropy(np.full((3, 3, 3), 77, dtype=np.uint8)) == 0.0


def test_entropy_rounds_the_grey_image_to_whole_levels():
    red_one = np.zeros((2, 2, 3), dtype=np.uint8)
    red_one[0, 0, 0] = 1  # 0.299 of a level rounds to 0
    red_two = red_one * 2  # 0.598 rounds to 1
    assert brightening_entropy(red_one) == 0.0
    assert brightening_entropy(red_two) > 0.8


def test_channels_that_brighten_alike_correlate_fully():
    grey = np.random.default_rng(0).integers(0, 120, (8, 8, 1), dtype=np.uint8)
    assert brightening_correlation(np.concatenate([grey, 2 * grey, grey + 7], axis=2)) == pytest.approx(1.0)


def test_opposite_channels_give_minus_one_for_their_pairs():
    values = np.array([[[1, 9, 1], [9, 1, 9]]], dtype=np.uint8)  # r,g: -1; g,b: -1; r,b: 1
    assert brightening_correlation(values) == pytest.approx(-1 / 3)


def test_constant_channel_counts_as_uncorrelated():
    values = np.array([[[1, 1, 5], [9, 9, 5]]], dtype=np.uint8)  # r,g: 1; both pairs with blue: 0
    assert brightening_correlation(values) == pytest.approx(1 / 3)
    assert brightening_correlation(np.zeros((4, 4, 3), dtype=np.uint8)) == 0.0


def test_correlation_stays_exact_for_large_bright_images():
    frame = np.full((480, 640, 3), 255, dtype=np.uint8)
    frame[0, 0] = 254
    assert brightening_correlation(frame) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("entropy", "correlation", "expected"),
    [
        (0.49, 0.9, Proximity.NORMAL),
        (0.5, 0.19, Proximity.APPROACHING),
        (0.5, 0.2, Proximity.NOISE),
        (7.0, -0.3, Proximity.APPROACHING),
    ],
)
def test_verdict_follows_the_published_thresholds(entropy, correlation, expected):
    assert decide_proximity(entropy, correlation, DetectorProfile()) is expected
