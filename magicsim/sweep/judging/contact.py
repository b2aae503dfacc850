"""How well the lightest touches are told from everything else, at places that the detector was not calibrated on.

Everything else is an object close by, outside light and nothing at all. With the camera's noise alone every touch would
be told from them; lights that are not as strong as when the detector was calibrated are what makes it hard.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from magicsim.arrays import Array, Index, Mask
from magicsim.detectors.verdict import Contact
from magicsim.judge.curves import roc_curve
from magicsim.sweep.judging.detector import TEST, FittedDetector
from magicsim.sweep.judging.filmed_design import REFERENCES, SPAN, Film, Shown
from magicsim.sweep.judging.measures import Measured

TEST_FIRST = 100
"""First noise stream of the test, beyond those of the training."""
MOST_CLEAR = SPAN - REFERENCES - TEST_FIRST
"""Most untouched frames of the test: the streams after them are the references'."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactScores:
    """What a detector says at the test's places: similarities, and whether its combined verdict is Touched."""

    touched: Array
    """Similarity of the lightest touches, shape (places, draws)."""
    near: Array
    """Similarity in front of each place, shape (places, draws)."""
    clear: Array
    """Similarity of untouched frames, shape (frames,)."""
    hit: Mask
    """Verdict of the touches, shape (places, draws)."""
    near_alarm: Mask
    """Alarms of the frames in front of each place, shape (places, draws)."""
    light_alarm: Mask
    """Under outside light, shape (places of the light, draws)."""
    clear_alarm: Mask
    """Alarms of untouched frames, shape (frames,)."""


def contact_scores(film: Film, detector: FittedDetector, draws: int, *, drift: float) -> ContactScores:
    """Similarity and verdict of every test frame, under lights that have drifted (see `Film.frames`)."""

    def seen(states: Sequence[Shown]) -> tuple[Array, Mask]:
        rows = [detector.verdicts(film.frames(each, draws, first=TEST_FIRST, drift=drift)) for each in states]
        called = [[each.combined is Contact.TOUCHED for each in row] for row in rows]
        return np.array([[each.similarity for each in row] for row in rows]), np.array(called)

    touched, hit = seen(film.light_touches[TEST::2])
    near, near_alarm = seen(film.near[TEST::2])
    _, light_alarm = seen(film.light[TEST::2])
    count = min(draws * len(touched), MOST_CLEAR)
    clear = detector.verdicts(film.frames(film.untouched, count, first=TEST_FIRST, drift=drift))
    return ContactScores(
        touched=touched,
        near=near,
        clear=np.array([each.similarity for each in clear]),
        hit=hit,
        near_alarm=near_alarm,
        light_alarm=light_alarm,
        clear_alarm=np.array([each.combined is Contact.TOUCHED for each in clear]),
    )


def contact_auc(renderings: Sequence[ContactScores], *, seed: int) -> Measured:
    """Area under the ROC curve of the similarity, touched against near and untouched; mean over renderings.

    Outside light is none of it: it lowers the similarity more than any touch does, and only both algorithms together
    tell it from one.

    Args:
        renderings: Scores of each.
        seed: Of the bootstrap over renderings and places.
    """
    return Measured.mean_over([partial(_area, scores) for scores in renderings], len(renderings[0].touched), seed=seed)


def contact_accuracy(renderings: Sequence[ContactScores], *, seed: int) -> Measured:
    """Balanced accuracy of the combined verdict, alarms mean over what is no touch; mean over renderings.

    Args:
        renderings: Scores of each.
        seed: Of the bootstrap over renderings and places.
    """
    return Measured.mean_over(
        [partial(_accuracy, scores) for scores in renderings], len(renderings[0].touched), seed=seed
    )


def _area(scores: ContactScores, places: Index) -> float:
    positive = scores.touched[places].ravel()
    negative = np.concatenate([scores.near[places].ravel(), scores.clear])
    labels = np.arange(len(positive) + len(negative)) < len(positive)
    return roc_curve(-np.concatenate([positive, negative]), labels).area


def _accuracy(scores: ContactScores, places: Index) -> float:
    alarms = [each.mean() for each in (scores.near_alarm[places], scores.light_alarm, scores.clear_alarm)]
    return float(scores.hit[places].mean() + 1 - np.mean(alarms)) / 2
