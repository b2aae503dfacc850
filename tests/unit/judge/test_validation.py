import dataclasses

import numpy as np
import pytest
from detectors.test_calibrate import BASE, EPISODES, SMALL, accuracies, make_episode

from magicsim.detectors import FrameClass, fit_profile
from magicsim.judge.profile_fit import cross_validate, score_profile


def test_score_of_a_profile_is_that_of_its_verdicts():
    score = score_profile(BASE, EPISODES)
    assert (score.proximity.accuracy, score.contact.accuracy) == accuracies(BASE, EPISODES)


def test_episode_that_is_unlike_the_others_counts_against_the_fit():
    """Its Near frames brighten all channels alike, which only an episode's own labels could tell."""
    odd = make_episode(3)
    frames = [
        np.repeat(frame[..., :1], 3, axis=2) if each is FrameClass.NEAR else frame
        for frame, each in zip(odd.frames, odd.classes, strict=True)
    ]
    episodes = [*EPISODES, dataclasses.replace(odd, frames=frames)]
    unseen = cross_validate(BASE, episodes, SMALL)
    assert unseen.proximity.accuracy < 1.0
    assert unseen.frames["Near"] == 9
    assert cross_validate(BASE, EPISODES, SMALL).proximity.accuracy == 1.0


def test_each_episode_is_judged_without_itself(monkeypatch):
    seen = []

    def record(base, episodes, candidates):
        seen.append(list(episodes))
        return fit_profile(base, episodes, candidates)

    monkeypatch.setattr("magicsim.judge.profile_fit.fit_profile", record)
    cross_validate(BASE, EPISODES, SMALL)
    assert [[id(each) for each in rest] for rest in seen] == [[id(EPISODES[1])], [id(EPISODES[0])]]


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_episodes_give_no_score(count):
    found = cross_validate(BASE, EPISODES[:count], SMALL)
    assert found is None or count == 0
