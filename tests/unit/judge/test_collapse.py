"""What tells nothing apart is found on any number of takes."""

from dataclasses import replace

import numpy as np
import pytest
from evaluation.synthetic import judged

from magicsim.frame_class import FrameClass
from magicsim.judge.measures import estimate
from magicsim.judge.regression import CHANCE, Collapse, collapses
from magicsim.judge.tally import JudgedEpisode, confusion, tally

NAMES = [f"take-{number}" for number in range(6)]


def found(
    episodes: list[JudgedEpisode], before: list[JudgedEpisode] | None = None, *, coated: bool = False
) -> dict[str, Collapse]:
    takes = [each.tag.take for each in episodes]
    estimates = {name: estimate(name, tally(episodes), takes, resamples=99, seed=0) for name in CHANCE}
    return {each.of: each for each in collapses(episodes, estimates, before or [], coated=coated)}


def always(name: str = "a", **verdicts: str) -> JudgedEpisode:
    return replace(judged(name), **{field: (verdict,) * 18 for field, verdict in verdicts.items()})


def test_sound_detector_and_one_with_a_few_mistakes_have_none():
    assert found([judged("a")]) == {}
    assert found([judged(name, miss=(0, 5, 11)) for name in NAMES]) == {}


def test_class_that_is_never_named_is_told_with_its_counts_on_a_single_take():
    never = found([always(contact="Untouched")])
    assert never["Contact"].says == "Contact is never named Touched: 0 of 4 frames"
    assert not never["Contact"].is_known
    near = found([judged("a", miss=range(4, 10))])
    assert near["Near"].says == "Near is never named Approaching: 0 of 6 frames"
    assert set(near) == {"Near"}  # 4 of 10 of contact are wrong too, which is above chance


@pytest.mark.parametrize(
    ("verdicts", "without"),
    [
        ({"contact": "Touched"}, {"Untouched", "contact_balanced_accuracy"}),
        ({"contact": "Unknown"}, {"Contact", "contact_balanced_accuracy"}),
        ({"proximity": "Approaching"}, {"Clear", "Light", "proximity_balanced_accuracy"}),
        ({"proximity": "Noise"}, {"Clear", "Near", "proximity_balanced_accuracy"}),
    ],
)
def test_verdict_that_is_always_given_leaves_the_other_classes_without_theirs(
    verdicts: dict[str, str], without: set[str]
):
    assert set(found([always(**verdicts)])) == without


def test_class_without_frames_is_none_that_is_never_named():
    lit = judged("a")
    only = replace(lit, labels=replace(lit.labels, classes=(None,) * 4 + lit.labels.classes[4:10] + (None,) * 8))
    assert confusion([only])["contact"][FrameClass.CONTACT] == {"Touched": 0, "Untouched": 0, "Unknown": 0}
    assert found([only]) == {}


def test_accuracy_whose_interval_holds_chance_is_a_collapse_and_one_above_is_none():
    random = np.random.default_rng(0)
    guess = [
        replace(judged(name), contact=tuple(random.choice(["Touched", "Untouched"], 18).tolist())) for name in NAMES
    ]
    assert "chance, 50.0 %" in found(guess)["contact_balanced_accuracy"].says
    assert "contact_balanced_accuracy" not in found([judged(name, miss=(10, 14)) for name in NAMES])


def test_what_the_baseline_does_not_tell_apart_either_is_told_and_known():
    never = [always(name, contact="Untouched") for name in NAMES]
    assert all(each.is_known for each in found(never, never).values())
    assert set(found(never, never)) == {"Contact", "contact_balanced_accuracy"}
    assert not any(each.is_known for each in found(never, [judged(name) for name in NAMES]).values())


def test_nothing_is_asked_of_proximity_behind_an_opaque_coat():
    assert set(found([always(proximity="Normal")])) == {"Near", "Light", "proximity_balanced_accuracy"}
    blind = [always(proximity="Normal")]
    none = {name: replace(estimate(name, tally(blind), ["a"], resamples=9, seed=0), value=None) for name in CHANCE}
    assert collapses(blind, none, coated=True) == []
