"""Receiver operating characteristic of one feature: every threshold with its hits and false alarms."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.errors import ConfigError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RocCurve:
    """Operating points from the strictest threshold to the loosest, each of shape (points,)."""

    thresholds: Array
    """Scores from which a frame counts as positive; the first is infinite."""
    hit_rate: Array
    """Share of positives at or above the threshold, 0..1, never falling."""
    false_alarm_rate: Array
    """Share of negatives at or above the threshold, 0..1, never falling."""
    area: float
    """Probability that a positive scores above a negative, a tie counting one half, 0..1."""


def roc_curve(scores: npt.ArrayLike, positive: npt.ArrayLike) -> RocCurve:
    """The curve of scores that are higher for positives.

    The area is the trapezoid rule over the points, which equals U / (n_+ n_-) of Mann and Whitney.

    Args:
        scores: One finite number a frame, shape (frames,).
        positive: Whether each frame is positive, shape (frames,).

    Raises:
        ConfigError: No positive or no negative frame, or a score that is not finite.
    """
    values, labels = np.asarray(scores, dtype=np.float64), np.asarray(positive, dtype=np.bool_)
    if not labels.any() or labels.all() or not np.isfinite(values).all():
        msg = f"{int(labels.sum())} of {labels.size} frames are positive; must be some, not all, with finite scores"
        raise ConfigError(msg)
    thresholds = np.unique(values)[::-1]
    hits = _share_from(values[labels], thresholds)
    alarms = _share_from(values[~labels], thresholds)
    return RocCurve(
        thresholds=np.concatenate([[np.inf], thresholds]),
        hit_rate=np.concatenate([[0.0], hits]),
        false_alarm_rate=np.concatenate([[0.0], alarms]),
        area=float(np.trapezoid(np.concatenate([[0.0], hits]), np.concatenate([[0.0], alarms]))),
    )


def rates_at(scores: npt.ArrayLike, positive: npt.ArrayLike, threshold: float) -> tuple[float, float]:
    """Hit rate and false alarm rate of one threshold; raises what `roc_curve` raises.

    Args:
        scores: One number a frame, shape (frames,).
        positive: Whether each frame is positive, shape (frames,).
        threshold: Score from which a frame counts as positive.
    """
    curve = roc_curve(scores, positive)
    at = int(np.searchsorted(-curve.thresholds, -threshold, side="right")) - 1
    return float(curve.hit_rate[at]), float(curve.false_alarm_rate[at])


def _share_from(values: Array, thresholds: Array) -> Array:
    """Share of values at or above each threshold."""
    return 1.0 - np.searchsorted(np.sort(values), thresholds, side="left") / len(values)
