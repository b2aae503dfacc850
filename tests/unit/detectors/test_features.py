import numpy as np
import pytest

from detectors.conftest import grid_frame, light_frame, near_frame
from magicsim.detectors import Episode, FrameClass, detect_all, fuse
from magicsim.detectors.features import measure_brightening, measure_similarity, scored_classes
from magicsim.errors import ConfigError, FrameError

FRAMES = [grid_frame(), near_frame(), light_frame(), grid_frame(2)]


def make_episode(**changes):
    classes = [FrameClass.CLEAR, None, FrameClass.LIGHT, FrameClass.CONTACT]
    return Episode(**{"references": [grid_frame()] * 6, "frames": FRAMES, "classes": classes} | changes)


def test_features_equal_those_of_detection_on_scored_frames(profile, references):
    episode = make_episode()
    verdicts = [each for index, each in enumerate(detect_all(FRAMES, references, profile)) if index != 1]
    entropy, correlation = measure_brightening([episode], profile, 0)
    assert entropy.tolist() == [each.entropy for each in verdicts]
    assert correlation.tolist() == [each.correlation for each in verdicts]
    option = (profile.tau_b, "dark", 0, 0)
    found = measure_similarity([episode], profile, [option], ["recall"])
    assert found[option, "recall"].tolist() == [each.similarity for each in verdicts]
    assert scored_classes([episode, episode]) == [FrameClass.CLEAR, FrameClass.LIGHT, FrameClass.CONTACT] * 2


def test_option_that_shows_no_grid_in_any_episode_has_no_feature(profile):
    bright = [np.full_like(grid_frame(), 90)] * 6
    episodes = [make_episode(), make_episode(references=bright)]
    found = measure_similarity(episodes, profile, [(35, "dark", 0, 0), (35, "bright", 0, 0)], ["iou"])
    assert found[(35, "dark", 0, 0), "iou"] is None
    assert len(found[(35, "bright", 0, 0), "iou"]) == 6


def test_as_many_classes_as_frames_are_needed():
    with pytest.raises(ConfigError, match="4 frames and 1 classes"):
        make_episode(classes=[None])


def test_too_few_references_are_refused(profile):
    with pytest.raises(FrameError, match=r"2 reference frame\(s\)"):
        measure_brightening([make_episode(references=[grid_frame()] * 2)], profile, 0)
    assert fuse([grid_frame()] * 3, profile).grid.frames == 3
