"""Streams at rest: known rates of false alarms, margins in standard deviations, verdicts that stand on noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from evaluation.synthetic import judged
from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import LedDrift
from magicsim.evaluation.detector import Detection
from magicsim.evaluation.footage import ExposedTake, Footage
from magicsim.evaluation.rest import HOUR_S, log_odds, rest_streams
from magicsim.evaluation.take import Take
from magicsim.judge.tally import FIRST_PLACE, EpisodeTag

RATE = 15.0


class Drawn:
    """Says Touched wherever its score of noise alone is above 1/2."""

    def __init__(self, mean: float, seed: int = 0) -> None:
        self.mean, self.random = mean, np.random.default_rng(seed)

    def fit(self, references) -> None:
        assert len(references) == 2

    def step(self, frame) -> Detection:
        touch = float(expit(self.mean + self.random.standard_normal()))
        said = "Touched" if touch > 0.5 else "Untouched"
        similarity = 0.9 + 0.01 * float(self.random.standard_normal())
        return Detection(proximity="Normal", contact=said, approach=0.1, touch=touch, similarity=similarity)


def footage(*, place: str = FIRST_PLACE, noise: str = "rig") -> Footage:
    image = np.full((1, 16, 12, 3), 0.2, np.float32)
    count = 2
    take = Take(
        radiance=image, room=np.zeros(0, np.float32), state=np.zeros(count, np.int32),
        is_reference=np.ones(count, bool), gap_mm=np.full(count, np.nan), force_n=np.zeros(count),
        flashlight=np.zeros(count, bool),
    )  # fmt: skip
    tag = EpisodeTag(take="take", object="ball", role="training", path="story", light="dark", noise=noise, place=place)
    images = ExposedTake(take=take, camera=Camera(columns=12, rows=16), seed=3, frames_per_second=RATE)
    return Footage(tag=tag, labels=judged("a").labels, images=images, frames_per_second=RATE)


def streams(mean: float, seconds: float, episodes=(), films=None):
    return rest_streams(films or [footage()], episodes, lambda: Drawn(mean), seconds=seconds, who="drawn")


def test_interval_holds_the_rate_that_alarms_were_drawn_with():
    found = streams(-1.5, 200.0)[0]
    true = 0.066807 * RATE * HOUR_S  # a normal deviate above 1.5
    assert found.frames == 3000
    assert found.low < true < found.high
    assert found.expected_per_hour == pytest.approx(true, rel=0.15)


def test_margin_is_the_threshold_s_distance_in_standard_deviations():
    found = streams(-6.0, 200.0)[0]
    assert found.touch.margin_sd == pytest.approx(6, rel=0.05)
    assert (found.alarms, found.low) == (0, 0.0)
    assert found.high == pytest.approx(3.6889 / (200 / HOUR_S), rel=1e-3)  # exact for no event, two-sided


def test_right_verdicts_near_rest_are_counted_as_weak():
    one = judged("a")
    touch = np.full(18, 0.01)
    touch[10:14] = expit([-3.0, 0.5, 4.0, 9.0])  # the frames in contact, all called Touched
    found = streams(-2.0, 100.0, [replace(one, touch=touch, approach=np.full(18, 0.5))])[0]
    assert (found.touch.weak_verdicts, found.touch.verdicts) == (2, 4)


def test_measures_are_told_at_rest_and_how_far_touches_and_near_frames_are_from_it():
    similarity = np.full(18, 0.9)
    similarity[4:10], similarity[10:14] = 0.88, 0.7
    found = streams(-2.0, 200.0, [replace(judged("a"), features={"similarity": similarity})])[0].features
    assert list(found) == ["similarity"]  # what the detector does not tell is left out
    told = found["similarity"]
    assert (told.mean, told.sd) == (pytest.approx(0.9, abs=1e-3), pytest.approx(0.01, rel=0.05))
    assert (told.touch_d, told.approach_d) == (pytest.approx(-20, rel=0.06), pytest.approx(-2, abs=0.2))


def test_measures_without_frames_of_a_class_have_no_distance():
    told = streams(-2.0, 10.0)[0].features["similarity"]
    assert (told.touch_d, told.approach_d) == (None, None)


def test_scores_that_are_no_probabilities_have_no_margin():
    found = streams(-2.0, 10.0, [judged("a")])[0]
    assert found.touch is None
    assert found.approach is None
    assert found.expected_per_hour is None


def test_each_place_and_noise_is_filmed_once_and_not_at_all_with_no_time():
    films = [footage(), footage(), footage(place="bench"), footage(noise="high")]
    found = streams(-2.0, 1.0, films=films)
    assert [(each.place, each.noise) for each in found] == [("own", "rig"), ("bench", "rig"), ("own", "high")]
    assert streams(-2.0, 0.0) == []


def test_frames_at_rest_are_new_ones():
    images = footage().images
    at_rest, references = list(images.at_rest(3)), list(images.references())
    assert all((one != other).any() for one in at_rest for other in references)
    np.testing.assert_array_equal(at_rest[:2], list(images.at_rest(2)))


def test_stream_at_rest_goes_on_with_the_drift_of_the_references():
    images = footage().images
    camera = images.camera.model_copy(update={"led_drift": LedDrift(share=0.1, time_s=600.0)})
    for seed in range(5):
        drifting = replace(images, camera=camera, seed=seed)
        [*_, last], [first, *_] = drifting.references(), drifting.at_rest(2)
        assert first.mean() == pytest.approx(last.mean(), abs=1)


def test_no_stream_at_rest_is_filmed_where_something_passes(caplog: pytest.LogCaptureFixture):
    busy = footage(place="corridor")
    films = [footage(), replace(busy, images=replace(busy.images, passes=True))]
    assert [each.place for each in streams(-2.0, 1.0, films=films)] == ["own"]
    assert "no stream at rest is filmed in place corridor" in caplog.text


def test_odds_are_finite_at_the_ends():
    assert np.isfinite(log_odds(np.array([0.0, 0.5, 1.0]))).all()
