"""How far verdicts stand from what the untouched sensor does by itself."""

import numpy as np
import pytest

from magicsim.detectors import DetectorProfile, detect_sources
from magicsim.detectors.combined import behind_coat, judge
from magicsim.detectors.verdict import REPEATABILITY_SD, features_at_rest, marked

from .conftest import grid_frame

PROFILE = DetectorProfile()


def verdict(*, entropy: float = 0.1, correlation: float = 0.0, similarity: float = 0.99):
    return judge(entropy=entropy, correlation=correlation, similarity=similarity, profile=PROFILE)


@pytest.fixture
def rest():
    random = np.random.default_rng(0)
    noise = random.standard_normal((30, 2))
    return features_at_rest([verdict(entropy=1.0 + 0.3 * e, similarity=0.6 + 0.05 * s) for e, s in noise])


def test_verdict_is_weak_where_its_feature_is_nearer_to_rest_than_the_camera_repeats(rest):
    entropy, similarity = rest["entropy"], rest["similarity"]
    for distance, weak in ((0.9 * REPEATABILITY_SD, True), (1.1 * REPEATABILITY_SD, False), (-2.0, True)):
        touched = verdict(entropy=0.0, similarity=similarity.mean - distance * similarity.sd)
        expected = weak and touched.combined == "Touched"
        assert marked(touched, rest).weak is expected
        near = verdict(entropy=entropy.mean + distance * entropy.sd)
        assert marked(near, rest).weak is (weak and near.proximity != "Normal")


def test_verdict_that_says_rest_is_never_weak(rest):
    assert marked(verdict(entropy=0.2, similarity=0.95), rest).weak is False


def test_behind_a_coat_brightening_counts_for_nothing(rest):
    bright = verdict(entropy=rest["entropy"].mean)
    assert marked(bright, rest).weak is True
    assert marked(behind_coat(bright), rest).weak is False


def test_a_verdict_without_its_rest_says_nothing_of_it():
    assert verdict().weak is None
    assert "weak" not in verdict().as_dict()


def test_sources_tell_weak_verdicts_by_their_references(tmp_path, save):
    random = np.random.default_rng(1)
    for index in range(32):
        frame = np.clip(grid_frame() + random.normal(0, 2, grid_frame().shape), 0, 255).astype(np.uint8)
        save(tmp_path / ("rest" if index < 30 else "now") / f"{index:02}.png", frame)
    found = detect_sources(tmp_path / "now", tmp_path / "rest", "published")
    assert all(each.weak is not None and each.as_dict()["weak"] is each.weak for each in found)
