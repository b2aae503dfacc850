"""How well touches are told from everything else, at places that the detector was not calibrated on."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.detectors.roc import roc_curve
from magicsim.detectors.verdict import Contact
from magicsim.sweep.bootstrap import Statistic, interval
from magicsim.sweep.detector import TEST, FittedDetector
from magicsim.sweep.film import Film
from magicsim.sweep.measures import Measured

TEST_FIRST = 100
"""First noise stream of the test, beyond those of the training."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactScores:
    """What a detector says at the test's places."""

    touched: npt.NDArray[np.float64]
    """Similarity, shape (places, draws)."""
    near: npt.NDArray[np.float64]
    """The same in front of each place."""
    clear: npt.NDArray[np.float64]
    """Of untouched frames, shape (frames,)."""
    hit: npt.NDArray[np.bool_]
    """Whether the combined verdict of each touched frame is Touched, shape (places, draws)."""
    near_alarm: npt.NDArray[np.bool_]
    clear_alarm: npt.NDArray[np.bool_]


def contact_scores(film: Film, detector: FittedDetector, draws: int) -> ContactScores:
    """Similarity and verdict of every test frame."""
    touched = [detector.verdicts(film.frames(each, draws, first=TEST_FIRST)) for each in film.touches[TEST::2]]
    near = [detector.verdicts(film.frames(each, draws, first=TEST_FIRST)) for each in film.near[TEST::2]]
    clear = detector.verdicts(film.frames(film.untouched, draws * len(touched), first=TEST_FIRST))
    return ContactScores(
        touched=np.array([[each.similarity for each in row] for row in touched]),
        near=np.array([[each.similarity for each in row] for row in near]),
        clear=np.array([each.similarity for each in clear]),
        hit=np.array([[each.combined is Contact.TOUCHED for each in row] for row in touched]),
        near_alarm=np.array([[each.combined is Contact.TOUCHED for each in row] for row in near]),
        clear_alarm=np.array([each.combined is Contact.TOUCHED for each in clear]),
    )


def contact_auc(scores: ContactScores, *, seed: int) -> Measured:
    """Area under the ROC curve of the similarity, bootstrapped over places."""

    def area(places: npt.NDArray[np.int64]) -> float:
        positive = scores.touched[places].ravel()
        negative = np.concatenate([scores.near[places].ravel(), scores.clear])
        labels = np.arange(len(positive) + len(negative)) < len(positive)
        return roc_curve(-np.concatenate([positive, negative]), labels).area

    return _over_places(area, len(scores.touched), seed)


def contact_accuracy(scores: ContactScores, *, seed: int) -> Measured:
    """Balanced accuracy of the combined verdict, bootstrapped over places."""

    def accuracy(places: npt.NDArray[np.int64]) -> float:
        alarms = np.concatenate([scores.near_alarm[places].ravel(), scores.clear_alarm])
        return float(scores.hit[places].mean() + 1 - alarms.mean()) / 2

    return _over_places(accuracy, len(scores.touched), seed)


def _over_places(statistic: Statistic, places: int, seed: int) -> Measured:
    low, high = interval(statistic, places, seed=seed)
    return Measured(value=statistic(np.arange(places)), low=low, high=high)
