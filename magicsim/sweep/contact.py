"""How well the lightest touches are told from everything else, at places that the detector was not calibrated on.

Everything else is an object close by, outside light and nothing at all. With the camera's noise alone every touch would
be told from them; lights that are not as strong as when the detector was calibrated are what makes it hard.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.detectors.roc import roc_curve
from magicsim.detectors.verdict import Contact
from magicsim.sweep.bootstrap import Statistic, interval
from magicsim.sweep.detector import TEST, FittedDetector
from magicsim.sweep.film import Film, Shown
from magicsim.sweep.measures import Measured

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
TEST_FIRST = 100
"""First noise stream of the test, beyond those of the training."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactScores:
    """What a detector says at the test's places: similarities, and whether its combined verdict is Touched."""

    touched: Array
    """Similarity of the lightest touches, shape (places, draws)."""
    near: Array
    """The same in front of each place."""
    clear: Array
    """Of untouched frames, shape (frames,)."""
    hit: Mask
    """Verdict of the touches, shape (places, draws)."""
    near_alarm: Mask
    light_alarm: Mask
    clear_alarm: Mask


def contact_scores(film: Film, detector: FittedDetector, draws: int, *, drift: float) -> ContactScores:
    """Similarity and verdict of every test frame, under lights that have drifted (see `Film.frames`)."""

    def seen(states: Sequence[Shown]) -> tuple[Array, Mask]:
        rows = [detector.verdicts(film.frames(each, draws, first=TEST_FIRST, drift=drift)) for each in states]
        called = [[each.combined is Contact.TOUCHED for each in row] for row in rows]
        return np.array([[each.similarity for each in row] for row in rows]), np.array(called)

    touched, hit = seen(film.light_touches[TEST::2])
    near, near_alarm = seen(film.near[TEST::2])
    _, light_alarm = seen(film.light[TEST::2])
    clear = detector.verdicts(film.frames(film.untouched, draws * len(touched), first=TEST_FIRST, drift=drift))
    return ContactScores(
        touched=touched,
        near=near,
        clear=np.array([each.similarity for each in clear]),
        hit=hit,
        near_alarm=near_alarm,
        light_alarm=light_alarm,
        clear_alarm=np.array([each.combined is Contact.TOUCHED for each in clear]),
    )


def contact_auc(scores: ContactScores, *, seed: int) -> Measured:
    """Area under the ROC curve of the similarity, touched against near and untouched, bootstrapped over places.

    Outside light is none of it: it lowers the similarity more than any touch does, and only both algorithms together
    tell it from one.
    """

    def area(places: npt.NDArray[np.int64]) -> float:
        positive = scores.touched[places].ravel()
        negative = np.concatenate([scores.near[places].ravel(), scores.clear])
        labels = np.arange(len(positive) + len(negative)) < len(positive)
        return roc_curve(-np.concatenate([positive, negative]), labels).area

    return _over_places(area, len(scores.touched), seed)


def contact_accuracy(scores: ContactScores, *, seed: int) -> Measured:
    """Balanced accuracy of the combined verdict, alarms mean over what is no touch, bootstrapped over places."""

    def accuracy(places: npt.NDArray[np.int64]) -> float:
        alarms = [each.mean() for each in (scores.near_alarm[places], scores.light_alarm, scores.clear_alarm)]
        return float(scores.hit[places].mean() + 1 - np.mean(alarms)) / 2

    return _over_places(accuracy, len(scores.touched), seed)


def _over_places(statistic: Statistic, places: int, seed: int) -> Measured:
    low, high = interval(statistic, places, seed=seed)
    return Measured(value=statistic(np.arange(places)), low=low, high=high)
