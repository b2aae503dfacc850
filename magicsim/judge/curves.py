"""Receiver operating characteristics, and curves over distance and depth at a fixed share of false alarms."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass
from magicsim.judge.measures import LEAST_EPISODES, ends
from magicsim.judge.tally import JudgedEpisode, class_scores


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
    """The curve of finite scores that are higher for positives, both of shape (frames,).

    The area is the trapezoid rule over the points, which equals U / (n_+ n_-) of Mann and Whitney.

    `ConfigError` where no frame is positive or none negative, or a score is not finite.
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
    """Hit rate and false alarm rate of one threshold; raises what `roc_curve` raises."""
    curve = roc_curve(scores, positive)
    at = int(np.searchsorted(-curve.thresholds, -threshold, side="right")) - 1
    return float(curve.hit_rate[at]), float(curve.false_alarm_rate[at])


def _share_from(values: Array, thresholds: Array) -> Array:
    """Share of values at or above each threshold."""
    return 1.0 - np.searchsorted(np.sort(values), thresholds, side="left") / len(values)


GAPS_MM = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 15.0, 20.0, 30.0)
"""Edges of the bins of distance [mm]; a bin includes its upper edge."""
DEPTHS_MM = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.6, 1.0, 2.0)
"""Edges of the bins of depth [mm]: up to 0.3 mm too shallow to be scored, beyond it scored."""
ROUNDING_MM = 1e-9
ROUNDING = 1e-6
"""Rounding of counts of frames, which are whole."""
NOTHING_NEAR = {FrameClass.CLEAR, FrameClass.LIGHT}
NO_TOUCH = {FrameClass.CLEAR, FrameClass.NEAR, FrameClass.LIGHT}


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoint:
    """Share of the frames of one bin that are detected."""

    above_mm: float
    to_mm: float
    frames: int
    rate: float
    low: float | None
    high: float | None
    """95 % interval over episodes; None of fewer than three."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Roc:
    """Trade-off between detections and false alarms."""

    false_alarms: list[float]
    detections: list[float]
    average_precision: float


def detection_by_distance(
    episodes: Sequence[JudgedEpisode], *, false_alarm_rate: float, resamples: int, seed: int
) -> list[CurvePoint]:
    """Share of frames with an object in front whose approach score is above the threshold of Clear and Light frames."""
    places = [np.where(each.labels.gap_mm > 0, each.labels.gap_mm, np.nan) for each in episodes]
    return _curve(episodes, places, "approach", NOTHING_NEAR, GAPS_MM, false_alarm_rate, resamples, seed)


def detection_by_depth(
    episodes: Sequence[JudgedEpisode], *, false_alarm_rate: float, resamples: int, seed: int
) -> list[CurvePoint]:
    """Share of frames with contact whose touch score is above the threshold of frames without."""
    places = [np.where(each.labels.force_n > 0, -each.labels.gap_mm, np.nan) for each in episodes]
    return _curve(episodes, places, "touch", NO_TOUCH, DEPTHS_MM, false_alarm_rate, resamples, seed)


def trade_off(
    episodes: Sequence[JudgedEpisode], score: str, positives: set[FrameClass], negatives: set[FrameClass]
) -> Roc | None:
    """ROC curve of all frames together, and its average precision; None where a side has no frames.

    The average precision is the sum of the precisions at all thresholds, each times the detections that it adds.
    """
    above = np.concatenate([class_scores(each, score, positives) for each in episodes] or [np.empty(0)])
    below = np.concatenate([class_scores(each, score, negatives) for each in episodes] or [np.empty(0)])
    if not len(above) or not len(below):
        return None
    curve = roc_curve(np.concatenate([above, below]), np.arange(len(above) + len(below)) < len(above))
    hits, alarms = curve.hit_rate * len(above), curve.false_alarm_rate * len(below)
    bends = np.abs(np.diff(hits, 2)) + np.abs(np.diff(alarms, 2)) > ROUNDING
    corners = np.concatenate([[True], bends, [True]])  # points on a straight line say nothing
    precision = hits[1:] / (hits[1:] + alarms[1:])
    return Roc(
        false_alarms=curve.false_alarm_rate[corners].round(6).tolist(),
        detections=curve.hit_rate[corners].round(6).tolist(),
        average_precision=float(np.diff(curve.hit_rate) @ precision),
    )


def threshold_at(negatives: Array, false_alarm_rate: float) -> float:
    """Smallest score above which at most a given share of the negatives lies."""
    return float(np.quantile(negatives, 1 - false_alarm_rate, method="inverted_cdf"))


def _curve(
    episodes: Sequence[JudgedEpisode], places: Sequence[Array], score: str, nothing: set[FrameClass],
    edges: tuple[float, ...], false_alarm_rate: float, resamples: int, seed: int,
) -> list[CurvePoint]:  # fmt: skip
    scores = [np.asarray(getattr(each, score), np.float64) for each in episodes]
    negatives = [class_scores(each, score, nothing) for each in episodes]
    # Upper edges belong to their bin, as 3 mm belongs to Near and 0.3 mm to Contact's lower limit of depth.
    bins = [np.searchsorted(np.array(edges) + ROUNDING_MM, place, side="left") - 1 for place in places]
    count = len(edges) - 1
    inside = [(place >= 0) & (place < count) for place in bins]  # NaN lies beyond the last edge
    whole = np.array([np.bincount(b[ok], minlength=count)[:count] for b, ok in zip(bins, inside, strict=True)])

    def rates(drawn: Index) -> Array:
        pool = np.concatenate([negatives[each] for each in drawn])
        if not len(pool) or not whole.size:
            return np.full(count, np.nan)
        threshold = threshold_at(pool, false_alarm_rate)
        hits = np.zeros(count)
        for each in drawn:
            hit = inside[each] & (scores[each] > threshold)
            hits += np.bincount(bins[each][hit], minlength=count)[:count]
        total = whole[drawn].sum(0)
        return np.where(total > 0, hits / np.maximum(total, 1), np.nan)

    found = rates(np.arange(len(episodes)))
    draws = np.random.default_rng(seed).integers(0, len(episodes), (resamples, len(episodes)))
    spread = np.array([rates(drawn) for drawn in draws]) if len(episodes) >= LEAST_EPISODES else None
    points = []
    for index in np.flatnonzero(np.isfinite(found)).tolist():
        low = high = None
        if spread is not None and np.isfinite(spread[:, index]).any():
            low, high = ends(spread[:, index])
        points.append(
            CurvePoint(
                above_mm=edges[index], to_mm=edges[index + 1], frames=int(whole[:, index].sum()),
                rate=float(found[index]), low=low, high=high,
            )
        )  # fmt: skip
    return points
