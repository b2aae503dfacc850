import numpy as np
import pytest
from evaluation.synthetic import judged
from sklearn.metrics import precision_recall_fscore_support, roc_auc_score

from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.frame_class import FrameClass
from magicsim.judge.measures import COMPUTE, measure
from magicsim.judge.score import score_verdicts
from magicsim.judge.tally import JudgedEpisode, approach_lead, class_scores, tally, touch_onset

MIXED = [
    judged("a", miss=(0, 5, 11), sharpness=1.0),
    judged("b", miss=(8, 15, 16), sharpness=0.5),
    judged("c", miss=(2, 3, 10, 12), sharpness=2.0),
]


def verdicts(episode: JudgedEpisode) -> list[Verdict]:
    return [
        Verdict(
            entropy=0, correlation=0, similarity=0, p_approach=0, p_noise=0, p_touch=0,
            proximity=Proximity(near), contact=Contact.UNTOUCHED, combined=Contact(touch),
        )
        for near, touch in zip(episode.proximity, episode.contact, strict=True)
    ]  # fmt: skip


def test_balanced_accuracies_are_those_of_the_score():
    said = [each for episode in MIXED for each in verdicts(episode)]
    score = score_verdicts(said, [one for episode in MIXED for one in episode.labels.classes])
    table = tally(MIXED)
    assert measure("proximity_balanced_accuracy", table) == pytest.approx(score.proximity.accuracy)
    assert measure("contact_balanced_accuracy", table) == pytest.approx(score.contact.accuracy)
    assert measure("touch_recall", table) == pytest.approx(score.contact.recall["Contact"])
    assert 0.5 < score.contact.accuracy < 1


@pytest.mark.parametrize(
    ("name", "score", "positives"),
    [("approach_auc", "approach", {FrameClass.NEAR}), ("touch_auc", "touch", {FrameClass.CONTACT})],
)
def test_area_is_that_of_scikit_learn_for_any_weights(name: str, score: str, positives: set[FrameClass]):
    negatives = {FrameClass.CLEAR, FrameClass.LIGHT} | ({FrameClass.NEAR} if score == "touch" else set())
    weights = np.array([2.0, 0.0, 3.0])
    truth, values, frame_weights = [], [], []
    for weight, episode in zip(weights, MIXED, strict=True):
        for chosen, label in ((positives, 1), (negatives, 0)):
            found = class_scores(episode, score, chosen)
            truth += [label] * len(found)
            values += found.tolist()
            frame_weights += [weight] * len(found)
    expected = roc_auc_score(truth, values, sample_weight=frame_weights)
    assert COMPUTE[name](tally(MIXED), weights[None])[0] == pytest.approx(expected)
    assert expected < 1


def test_precision_is_that_of_scikit_learn():
    scored = [
        (one is FrameClass.NEAR, near == Proximity.APPROACHING)
        for episode in MIXED
        for one, near in zip(episode.labels.classes, episode.proximity, strict=True)
        if one is not FrameClass.CONTACT and one is not None
    ]
    truth, said = zip(*scored, strict=True)
    precision, recall, *_ = precision_recall_fscore_support(truth, said, average="binary")
    assert measure("approach_precision", tally(MIXED)) == pytest.approx(precision)
    assert measure("approach_recall", tally(MIXED)) == pytest.approx(recall)


def test_measure_without_frames_of_a_class_is_none():
    dark = judged("a")
    labels = dark.labels
    keep = slice(0, 4)
    only_clear = JudgedEpisode(
        tag=dark.tag,
        labels=type(labels).of(labels.gap_mm[keep], labels.force_n[keep], labels.flashlight[keep]),
        proximity=dark.proximity[keep], contact=dark.contact[keep], approach=dark.approach[keep],
        touch=dark.touch[keep],
    )  # fmt: skip
    table = tally([only_clear])
    assert measure("clear_recall", table) == 1
    for name in ("proximity_balanced_accuracy", "approach_auc", "touch_auc", "lead_mm", "onset_mm"):
        assert measure(name, table) is None


def test_lead_counts_back_from_contact_to_the_last_gap_in_the_verdicts():
    assert approach_lead(judged("a")).gap_mm == 3.0
    assert approach_lead(judged("a")).frames == 6
    broken = approach_lead(judged("a", miss=(6,)))
    assert (broken.frames, broken.gap_mm) == (3, 1.0)
    assert broken.seconds == pytest.approx(3 / 15)
    assert approach_lead(judged("a", miss=(9,))).gap_mm == 0.0


def test_onset_is_the_first_touched_and_the_deepest_where_there_is_none():
    assert (touch_onset(judged("a")).depth_mm, touch_onset(judged("a")).frames) == (0.3, 0)
    late = touch_onset(judged("a", miss=(10, 11)))
    assert (late.depth_mm, late.frames) == (0.8, 2)
    never = touch_onset(judged("a", miss=(10, 11, 12, 13)))
    assert (never.depth_mm, never.frames) == (1.0, 4)


def test_onset_is_that_of_the_first_touch_that_has_to_be_noticed():
    blind = judged("a", miss=(10, 11, 12, 13))
    blind.labels.gap_mm[5] = -0.1  # a light touch, lifted again
    assert (touch_onset(blind).depth_mm, touch_onset(blind).frames) == (1.0, 4)
    unknown = judged("a")
    unknown.labels.gap_mm[10] = np.nan
    assert touch_onset(unknown) is None
