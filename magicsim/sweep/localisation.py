"""Where a touch was, by a regressor that anyone would try first: ridge regression on where the image changes.

The features are six numbers a frame. With a dozen touches, whole small images as features do several times worse.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index
from magicsim.detectors.frame import Frame
from magicsim.sweep.film import DesignFilm
from magicsim.sweep.measures import Measured

TINY = 1e-12
PENALTIES = (1e-4, 1e-3, 1e-2, 1e-1)
"""Penalties of the ridge, in units of the mean square of the features; chosen without the place that is left out."""
DRAWS = 2
"""Frames of each touch."""
FIRST = 300
"""First noise stream."""


def change_centroids(frame: npt.ArrayLike, reference: Array) -> Array:
    """Centroid of the squared change from the mean untouched frame, column and row of each channel, shape (6,).

    In shares of the image's size from its centre; both images have shape (rows, columns, 3).
    """
    change = np.square(np.asarray(frame, float) - reference)
    total = np.maximum(change.sum((0, 1)), TINY)
    parts = []
    for axis in (1, 0):
        place = (np.arange(change.shape[axis]) + 0.5) / change.shape[axis] - 0.5
        parts.append(np.tensordot(place, change.sum(1 - axis), (0, 0)) / total)
    return np.concatenate(parts)


def localisation_error(predicted: Sequence[Array], places: Array, *, seed: int) -> Measured:
    """Root mean square error of the place of a touch, mean over renderings [mm].

    Places, predicted by each rendering and true, have shape (touches, 2) [mm].
    """

    def error(squared: Array, numbers: Index) -> float:
        return float(np.sqrt(squared[numbers].mean()))

    errors = [partial(error, ((each - places) ** 2).sum(1)) for each in predicted]
    return Measured.mean_over(errors, len(places), seed=seed)


def predicted_places(film: DesignFilm) -> Array:
    """Place of each touch as the regressor says that has seen the others, shape (touches, 2) [mm]."""
    reference = np.mean(film.references(), axis=0)
    features = np.stack([_mean_features(film.frames(each, DRAWS, first=FIRST), reference) for each in film.touches])
    return left_out_predictions(features, true_places(film))


def true_places(film: DesignFilm) -> Array:
    """Place of each touch, shape (touches, 2) [mm]."""
    return np.array([[each.x_mm, each.y_mm] for each in film.touches])


def left_out_predictions(features: Array, targets: Array) -> Array:
    """Predictions of each row by a ridge regression on all other rows, shape (rows, targets)."""
    rows = np.arange(len(features))
    result = np.zeros_like(targets)
    for held in rows:
        rest = rows != held
        penalty = min(PENALTIES, key=lambda each: _left_out_error(features[rest], targets[rest], each))
        result[held] = _predict(features[rest], targets[rest], features[held : held + 1], penalty)[0]
    return result


def _left_out_error(features: Array, targets: Array, penalty: float) -> float:
    rows = np.arange(len(features))
    missed = [
        _predict(features[rows != held], targets[rows != held], features[held : held + 1], penalty)[0] - targets[held]
        for held in rows
    ]
    return float(np.square(missed).sum())


def _predict(features: Array, targets: Array, asked: Array, penalty: float) -> Array:
    """Ridge regression in its dual form, for fewer rows than features."""
    mean, centre = features.mean(0), targets.mean(0)
    rows = features - mean
    gram = rows @ rows.T
    weights = np.linalg.solve(gram + penalty * np.trace(gram) / len(rows) * np.eye(len(rows)), targets - centre)
    return np.asarray((asked - mean) @ rows.T @ weights + centre)


def _mean_features(frames: Sequence[Frame], reference: Array) -> Array:
    return np.asarray(np.mean([change_centroids(frame, reference) for frame in frames], axis=0))
