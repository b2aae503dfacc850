"""The measures of a detector as functions of a tally and of weights of its episodes, and their confidence intervals.

All but the areas under the curve are ratios of weighted sums. With p_ij the rightly ordered pairs of a positive frame
of episode i and a negative one of episode j, the area (Hanley and McNeil 1982) is sum w_i w_j p_ij / (sum w_i P_i
sum w_j N_j). Intervals are those of the bootstrap over whole episodes (Efron and Tibshirani 1993; Field and Welsh
2007).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import binomtest

from magicsim.arrays import Array, Index
from magicsim.judge.tally import Tally
from magicsim.sampling.bootstrap import CONFIDENCE, ends, resampled

Measure = Callable[[Tally, Array], Array]
"""From a tally and weights, shape (resamples, episodes), to values, shape (resamples,); NaN where undefined."""
UNTOUCHED = ("Clear", "Near", "Light")


@dataclass(frozen=True, slots=True)
class DetectorMeasure:
    """A measure and which way is better."""

    title: str
    compute: Measure
    unit: str = ""
    better: Literal["higher", "lower"] = "higher"


def _ratio(part: Array, whole: Array, weights: Array) -> Array:
    total = weights @ whole
    return np.where(total > 0, (weights @ part) / np.where(total > 0, total, 1), np.nan)


def _recall(truth: str, verdict: str) -> Measure:
    return lambda table, weights: _ratio(table.count[f"{truth} said {verdict}"], table.count[truth], weights)


def _proximity_accuracy(table: Tally, weights: Array) -> Array:
    pairs = (("Clear", "Normal"), ("Near", "Approaching"), ("Light", "Noise"))
    return np.mean([_recall(*pair)(table, weights) for pair in pairs], axis=0)  # type: ignore[no-any-return]


def _untouched(table: Tally) -> tuple[Array, Array]:
    wrong = sum((table.count[f"{each} said Touched"] for each in UNTOUCHED), np.zeros(table.episodes))
    total = sum((table.count[each] for each in UNTOUCHED), np.zeros(table.episodes))
    return wrong, total


def _contact_accuracy(table: Tally, weights: Array) -> Array:
    wrong, total = _untouched(table)
    touched = _recall("Contact", "Touched")(table, weights)
    return (touched + 1 - _ratio(wrong, total, weights)) / 2


def _approach_precision(table: Tally, weights: Array) -> Array:
    right = table.count["Near said Approaching"]
    said = sum((table.count[f"{each} said Approaching"] for each in UNTOUCHED), np.zeros(table.episodes))
    return _ratio(right, said, weights)


def _touch_precision(table: Tally, weights: Array) -> Array:
    right = table.count["Contact said Touched"]
    return _ratio(right, right + _untouched(table)[0], weights)


def _area(score: str, positives: tuple[str, ...], negatives: tuple[str, ...]) -> Measure:
    def compute(table: Tally, weights: Array) -> Array:
        above = weights @ sum((table.count[each] for each in positives), np.zeros(table.episodes))
        below = weights @ sum((table.count[each] for each in negatives), np.zeros(table.episodes))
        ordered = np.einsum("ri,ij,rj->r", weights, table.pairs[score], weights, optimize=True)
        total = above * below
        return np.where(total > 0, ordered / np.where(total > 0, total, 1), np.nan)

    return compute


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreMean:
    """Mean of a score over the frames of some classes."""

    title: str
    score: Literal["approach", "touch"]
    classes: tuple[str, ...]
    is_positive: bool = False
    """Whether the score should be high there."""


SCORE_MEANS: Mapping[str, ScoreMean] = {
    "clear_score": ScoreMean(title="Clear, mean score of an approach", score="approach", classes=("Clear",)),
    "near_score": ScoreMean(
        title="Near, mean score of an approach", score="approach", classes=("Near",), is_positive=True
    ),
    "light_score": ScoreMean(title="Light, mean score of an approach", score="approach", classes=("Light",)),
    "untouched_score": ScoreMean(title="No contact, mean score of a touch", score="touch", classes=UNTOUCHED),
    "contact_score": ScoreMean(
        title="Contact, mean score of a touch", score="touch", classes=("Contact",), is_positive=True
    ),
}
"""Those that are measured, by the name they have in the JSON."""


def _score(score: str, classes: tuple[str, ...]) -> Measure:
    """Mean score of the frames of some classes."""

    def compute(table: Tally, weights: Array) -> Array:
        total = sum((table.count[f"{each} {score}"] for each in classes), np.zeros(table.episodes))
        frames = sum((table.count[each] for each in classes), np.zeros(table.episodes))
        return _ratio(total, frames, weights)

    return compute


def _mean(name: str) -> Measure:
    def compute(table: Tally, weights: Array) -> Array:
        known = ~np.isnan(table.value[name])
        return _ratio(np.where(known, table.value[name], 0.0), known.astype(np.float64), weights)

    return compute


MEASURES: Mapping[str, DetectorMeasure] = {
    "proximity_balanced_accuracy": DetectorMeasure("Proximity, balanced accuracy", _proximity_accuracy),
    "contact_balanced_accuracy": DetectorMeasure("Contact, balanced accuracy", _contact_accuracy),
    "clear_recall": DetectorMeasure("Clear called Normal", _recall("Clear", "Normal")),
    "approach_recall": DetectorMeasure("Near called Approaching (recall)", _recall("Near", "Approaching")),
    "approach_precision": DetectorMeasure("Approaching that is Near (precision)", _approach_precision),
    "light_recall": DetectorMeasure("Light called Noise", _recall("Light", "Noise")),
    "touch_recall": DetectorMeasure("Contact called Touched (recall)", _recall("Contact", "Touched")),
    "touch_precision": DetectorMeasure("Touched that is Contact (precision)", _touch_precision),
    "approach_auc": DetectorMeasure(
        "Approach, area under the ROC curve", _area("approach", ("Near",), ("Clear", "Light"))
    ),
    "touch_auc": DetectorMeasure("Touch, area under the ROC curve", _area("touch", ("Contact",), UNTOUCHED)),
    **{
        name: DetectorMeasure(
            each.title, _score(each.score, each.classes), better="higher" if each.is_positive else "lower"
        )
        for name, each in SCORE_MEANS.items()
    },
    "light_false_alarms": DetectorMeasure(
        "Light alone called Approaching or Touched",
        lambda table, weights: _ratio(table.count["Light alarmed"], table.count["Light"], weights),
        better="lower",
    ),
    "lead_mm": DetectorMeasure("Lead: gap at which an approach is noticed for good", _mean("lead_mm"), unit="mm"),
    "lead_frames": DetectorMeasure("Lead before contact", _mean("lead_frames"), unit="frames"),
    "lead_s": DetectorMeasure("Lead before contact", _mean("lead_s"), unit="s"),
    "onset_mm": DetectorMeasure("Depth at which a touch is noticed", _mean("onset_mm"), unit="mm", better="lower"),
    "latency_frames": DetectorMeasure(
        "Contact frames before Touched", _mean("latency_frames"), unit="frames", better="lower"
    ),
}
"""All measures by the name they have in the JSON."""
OF_PROXIMITY = frozenset({
    "proximity_balanced_accuracy", "clear_recall", "approach_recall", "approach_precision", "light_recall",
    "approach_auc", "clear_score", "near_score", "light_score", "lead_mm", "lead_frames", "lead_s",
})  # fmt: skip
"""Measures that nothing is known of behind an opaque coat."""


def measure(name: str, table: Tally) -> float | None:
    """A measure of all episodes; None where it is not defined."""
    value = float(MEASURES[name].compute(table, np.ones((1, table.episodes)))[0])
    return None if np.isnan(value) else value


LEAST_EPISODES = 3
"""Fewer episodes give no interval: their spread says nothing of other episodes."""
MOST_UNDEFINED = 0.2
"""Share of resamples in which a measure may be undefined, because a class is missing, before its interval is None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureEstimate:
    """A measure with its confidence interval."""

    value: float | None
    """None where a class has no frames."""
    low: float | None
    high: float | None
    """Ends of the 95 % percentile interval; None of fewer than three episodes."""
    episodes: int


def weights_of(indices: Index, episodes: int) -> Array:
    """How often each episode was drawn, shape (resamples, episodes), by indices of shape (resamples, draws)."""
    rows = np.repeat(np.arange(len(indices)), indices.shape[1])
    counts = np.bincount(rows * episodes + indices.ravel(), minlength=len(indices) * episodes)
    return counts.reshape(-1, episodes).astype(np.float64)


def estimate(name: str, table: Tally, groups: Sequence[str], *, resamples: int, seed: int) -> MeasureEstimate:
    """One measure of a tally with its interval; episodes of one group are drawn together, since they share a take."""
    value = measure(name, table)
    labels = list(dict.fromkeys(groups))
    low = high = None
    if value is not None and len(labels) >= LEAST_EPISODES:
        member = np.array([[label == group for group in groups] for label in labels], np.float64)
        drawn = weights_of(resampled(len(labels), resamples, np.random.default_rng(seed)), len(labels))
        with np.errstate(invalid="ignore"):
            found = MEASURES[name].compute(table, drawn @ member)
        if np.isnan(found).mean() <= MOST_UNDEFINED:
            low, high = ends(found)
    return MeasureEstimate(value=value, low=low, high=high, episodes=len(labels))


def exact_share(successes: int, total: int) -> MeasureEstimate:
    """A share of independent episodes with its exact interval (Clopper and Pearson 1934).

    Where everything is right the bootstrap has nothing to spread and its interval collapses; this one does not.
    """
    if total == 0:
        return MeasureEstimate(value=None, low=None, high=None, episodes=0)
    ends = binomtest(successes, total).proportion_ci(CONFIDENCE, method="exact")
    return MeasureEstimate(value=successes / total, low=float(ends.low), high=float(ends.high), episodes=total)
