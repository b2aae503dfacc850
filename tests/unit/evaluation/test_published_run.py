"""What the published detectors say of dark items where the exposure follows (docs/operating-point.md)."""

from collections.abc import Sequence

import numpy as np
import pytest

from magicsim.detectors.profile import load_profile
from magicsim.detectors.verdict import Proximity
from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.detector import ProfileDetector
from magicsim.evaluation.footage import quick_suite, shipped_films
from magicsim.evaluation.suite import SHIPPED, load_suite
from magicsim.frame_class import FrameClass
from magicsim.judge.tally import JudgedEpisode
from magicsim.scenes.rig import load_rig

NEAR_AT_REST = 3
"""Near frames in which the exposure has not followed yet: it starts late and takes five frames."""


def judged(rig: str, item: str) -> JudgedEpisode:
    suite, _ = quick_suite(load_suite(SHIPPED, [f"rig='{rig}'"]))
    film = next(film for take in shipped_films(suite) for film in take if film.tag.object == item)
    return judge_footage(film, lambda: ProfileDetector(load_profile("published")), who="published")


def said(episode: JudgedEpisode, truth: FrameClass) -> Sequence[str]:
    return [word for word, one in zip(episode.proximity, episode.labels.classes, strict=True) if one is truth]


def test_rig_differs_from_the_default_in_its_exposure_alone():
    live, locked = load_rig("published-run"), load_rig("digit-office")
    assert live.camera.live is not None
    assert live.camera.model_copy(update={"live": None}) == locked.camera
    assert live.model_copy(update={"camera": locked.camera}) == locked


@pytest.mark.parametrize(("rig", "is_told"), [("digit-office", False), ("published-run", True)])
def test_dark_roll_is_told_where_the_exposure_follows(rig: str, is_told: bool):
    episode = judged(rig, "biscuit-packet")
    near, tau_e = said(episode, FrameClass.NEAR), load_profile("published").tau_e
    assert (near.count(Proximity.APPROACHING) >= len(near) - NEAR_AT_REST) is is_told
    assert (near.count(Proximity.APPROACHING) == 0) is not is_told
    assert bool(np.median(episode.features["entropy"][4:12]) > 2 * tau_e) is is_told
    assert set(said(episode, FrameClass.LIGHT)) == {Proximity.NOISE}
