import numpy as np
import pytest
from evaluation.synthetic import judged

from magicsim.frame_class import FrameClass
from magicsim.judge.curves import (
    NOTHING_NEAR,
    detection_by_depth,
    detection_by_distance,
    threshold_at,
    trade_off,
)
from magicsim.judge.tally import class_scores

OPTIONS = {"resamples": 50, "seed": 0}


def test_threshold_lets_at_most_the_given_share_through():
    random = np.random.default_rng(0)
    for count in (7, 20, 100):
        scores = random.standard_normal(count)
        for rate in (0.01, 0.05, 0.2):
            assert (scores > threshold_at(scores, rate)).mean() <= rate
            lower = scores[scores < threshold_at(scores, rate)]
            assert all((scores > each).mean() > rate for each in lower)
    assert (np.arange(100.0) > threshold_at(np.arange(100.0), 0.05)).mean() == 0.05


def test_sharp_scores_are_detected_everywhere_and_chance_at_the_false_alarm_rate():
    sharp = [judged(f"{number}", sharpness=50.0) for number in range(5)]
    assert [point.rate for point in detection_by_distance(sharp, false_alarm_rate=0.05, **OPTIONS)] == [1.0] * 4
    assert [point.rate for point in detection_by_depth(sharp, false_alarm_rate=0.05, **OPTIONS)] == [1.0] * 3
    blind = [judged(f"{number}", sharpness=0.0) for number in range(200)]
    points = detection_by_distance(blind, false_alarm_rate=0.2, resamples=20, seed=0)
    assert np.mean([point.rate for point in points]) == pytest.approx(0.2, abs=0.04)


def test_bins_hold_every_frame_once_with_its_upper_edge():
    points = detection_by_distance([judged("a"), judged("b"), judged("c")], false_alarm_rate=0.05, **OPTIONS)
    assert [(point.above_mm, point.to_mm, point.frames) for point in points] == [
        (0.0, 0.5, 6), (0.5, 1.0, 3), (1.0, 2.0, 3), (2.0, 3.0, 6),
    ]  # fmt: skip
    assert all(point.low <= point.rate <= point.high for point in points)


@pytest.mark.parametrize(("curve", "sign"), [(detection_by_distance, 1), (detection_by_depth, -1)])
def test_frame_that_rounding_alone_keeps_from_the_face_is_in_no_bin(curve, sign: int):
    episode = judged("a")
    episode.labels.gap_mm[13] = sign * 3e-17
    episode.labels.gap_mm[9] = np.nan
    points = [curve([each], false_alarm_rate=0.05, **OPTIONS) for each in (judged("a"), episode)]
    before, now = (sum(point.frames for point in each) for each in points)
    assert now == before - 1


def test_roc_runs_from_nothing_to_everything():
    curve = trade_off([judged("a", sharpness=1.0)], "approach", {FrameClass.NEAR}, NOTHING_NEAR)
    assert (curve.false_alarms[0], curve.detections[0]) == (0, 0)
    assert (curve.false_alarms[-1], curve.detections[-1]) == (1, 1)
    assert 0.4 < curve.average_precision <= 1
    assert trade_off([], "approach", {FrameClass.NEAR}, NOTHING_NEAR) is None


@pytest.mark.parametrize("digits", [1, 8])
def test_roc_is_that_of_an_independent_implementation(digits: int):
    metrics = pytest.importorskip("sklearn.metrics")
    episodes = [judged(f"{number}", sharpness=0.7) for number in range(6)]
    for each in episodes:
        each.approach[:] = np.round(each.approach, digits)  # ties
    curve = trade_off(episodes, "approach", {FrameClass.NEAR}, NOTHING_NEAR)
    near, clear = (
        np.concatenate([class_scores(each, "approach", kinds) for each in episodes])
        for kinds in ({FrameClass.NEAR}, NOTHING_NEAR)
    )
    truth = np.concatenate([np.ones(len(near)), np.zeros(len(clear))])
    scores = np.concatenate([near, clear])
    alarms, hits, _ = metrics.roc_curve(truth, scores)
    assert curve.false_alarms == pytest.approx(alarms.tolist(), abs=1e-6)
    assert curve.detections == pytest.approx(hits.tolist(), abs=1e-6)
    assert curve.average_precision == pytest.approx(metrics.average_precision_score(truth, scores))
