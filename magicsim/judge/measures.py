"""The table of all measures of a detector: their meaning, unit, and smallest fall that is tested; and intervals.

What `magicsim evaluate` prints, draws or stores has its row in `measures.csv`. Most are functions of a tally and of
weights of its episodes: all but the areas under the curve are ratios of weighted sums. With p_ij the rightly ordered
pairs of a positive frame of episode i and a negative one of episode j, the area (Hanley and McNeil 1982) is
sum w_i w_j p_ij / (sum w_i P_i sum w_j N_j).

Percentile intervals by drawing with replacement (Efron and Tibshirani 1993), on one level or two, of a detector's
measures over whole episodes (Field and Welsh 2007); exact ones of a share of independent trials (Clopper and Pearson
1934) and of a Poisson count (Garwood 1936), which stand also where nothing spreads.
"""

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.judge.tally import Tally

Compute = Callable[[Tally, Array], Array]
"""From a tally and weights, shape (resamples, episodes), to values, shape (resamples,); NaN where undefined."""
Better = Literal["higher", "lower"]
UNTOUCHED = ("Clear", "Near", "Light")
SHARE = "share"
"""Unit of what is told in per cent, 0..1 in the JSON."""
SCORE_MEANS: Mapping[str, tuple[Literal["approach", "touch"], tuple[str, ...]]] = {
    "clear_score": ("approach", ("Clear",)),
    "near_score": ("approach", ("Near",)),
    "light_score": ("approach", ("Light",)),
    "untouched_score": ("touch", UNTOUCHED),
    "contact_score": ("touch", ("Contact",)),
}
"""Measures that are the mean of a score over the frames of some classes."""
FILE = Path(__file__).with_suffix(".csv")
"""The table as the documentation shows it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureKind:
    """What a reader has to know of a measure, of a detector or of a design."""

    title: str
    meaning: str
    """One sentence on what is measured."""
    unit: str = ""
    """Empty for a pure number."""
    better: Better | None = "higher"
    """Which way is better; None where that depends on the job."""
    digits: int = 3
    """Decimals that are shown."""
    is_exact: bool = False
    """Whether it follows from the design alone; equal ends of another's interval say that all resamples were alike."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorMeasure(MeasureKind):
    """A row of the table."""

    task: str
    """`proximity`, of which nothing is known behind an opaque coat, `contact`, or empty."""
    column: str
    """Heading in the report's table of groups; empty for what is not there."""
    matters: float | None
    """Smallest fall in the standard condition that is a regression, of mean scores as a share of the distance between
    the baseline's classes: ten reruns of the built-in detectors under other camera noise stay below it
    (`benchmarks/injected_regressions.py`). None for what is not compared."""
    matters_elsewhere: float | None
    """Smallest fall in every other condition of light and noise, likewise."""


def _ratio(part: Array, whole: Array, weights: Array) -> Array:
    total = weights @ whole
    return np.where(total > 0, (weights @ part) / np.where(total > 0, total, 1), np.nan)


def _recall(truth: str, verdict: str) -> Compute:
    return lambda table, weights: _ratio(table.count[f"{truth} said {verdict}"], table.count[truth], weights)


def _proximity_accuracy(table: Tally, weights: Array) -> Array:
    pairs = (("Clear", "Normal"), ("Near", "Approaching"), ("Light", "Noise"))
    return np.mean([_recall(*pair)(table, weights) for pair in pairs], axis=0)  # type: ignore[no-any-return]


def _sum(table: Tally, classes: Sequence[str], what: str = "") -> Array:
    """Frames of some classes, of which something was said, or the sums of a score of theirs, shape (episodes,)."""
    return sum((table.count[f"{each}{what}"] for each in classes), np.zeros(table.episodes))


def _contact_accuracy(table: Tally, weights: Array) -> Array:
    wrong, total = _sum(table, UNTOUCHED, " said Touched"), _sum(table, UNTOUCHED)
    touched = _recall("Contact", "Touched")(table, weights)
    return (touched + 1 - _ratio(wrong, total, weights)) / 2


def _precision(truth: str, verdict: str, others: Sequence[str]) -> Compute:
    """Share of a class among the frames of it and of others that are named so."""
    said = f" said {verdict}"
    return lambda table, weights: _ratio(table.count[truth + said], _sum(table, (truth, *others), said), weights)


def _area(score: str, positives: tuple[str, ...], negatives: tuple[str, ...]) -> Compute:
    def compute(table: Tally, weights: Array) -> Array:
        ordered = np.einsum("ri,ij,rj->r", weights, table.pairs[score], weights, optimize=True)
        total = (weights @ _sum(table, positives)) * (weights @ _sum(table, negatives))
        return np.where(total > 0, ordered / np.where(total > 0, total, 1), np.nan)

    return compute


def _score(score: str, classes: tuple[str, ...]) -> Compute:
    """Mean score of the frames of some classes."""
    return lambda table, weights: _ratio(_sum(table, classes, f" {score}"), _sum(table, classes), weights)


def _mean(name: str) -> Compute:
    """Mean over the episodes that have such a value."""
    return lambda table, weights: _ratio(
        np.nan_to_num(table.value[name]), np.isfinite(table.value[name]).astype(np.float64), weights
    )


COMPUTE: Mapping[str, Compute] = {
    "proximity_balanced_accuracy": _proximity_accuracy,
    "contact_balanced_accuracy": _contact_accuracy,
    "clear_recall": _recall("Clear", "Normal"),
    "approach_recall": _recall("Near", "Approaching"),
    "approach_precision": _precision("Near", "Approaching", ("Clear", "Light")),
    "light_recall": _recall("Light", "Noise"),
    "touch_recall": _recall("Contact", "Touched"),
    "touch_precision": _precision("Contact", "Touched", UNTOUCHED),
    "approach_auc": _area("approach", ("Near",), ("Clear", "Light")),
    "touch_auc": _area("touch", ("Contact",), UNTOUCHED),
    **{name: _score(*of) for name, of in SCORE_MEANS.items()},
    "light_false_alarms": lambda table, weights: _ratio(table.count["Light alarmed"], table.count["Light"], weights),
    **{name: _mean(name) for name in ("lead_mm", "lead_frames", "lead_s", "onset_mm", "latency_frames")},
}
"""Measures of a tally."""


def _row(cells: Mapping[str, str]) -> DetectorMeasure:
    fall, elsewhere = (float(cells[name]) if cells[name] else None for name in ("smallest_fall", "elsewhere"))
    values: dict[str, Any] = {name: cells[name] for name in ("title", "meaning", "unit", "task", "column")}
    return DetectorMeasure(**values, better=cells["better"] or None, matters=fall, matters_elsewhere=elsewhere)  # type: ignore[arg-type]


with FILE.open(encoding="utf-8", newline="") as _file:
    TABLE: Mapping[str, DetectorMeasure] = {cells["name"]: _row(cells) for cells in csv.DictReader(_file)}
"""All measures by the name they have in the JSON."""


def measure(name: str, table: Tally) -> float | None:
    """A measure of all episodes; None where it is not defined."""
    value = float(COMPUTE[name](table, np.ones((1, table.episodes)))[0])
    return None if np.isnan(value) else value


Statistic = Callable[[Index], float]
"""Takes numbers of the drawn items, with repetition; NaN where it is not defined."""
CONFIDENCE = 0.95
TAIL = (1 - CONFIDENCE) / 2
RESAMPLES = 400


def interval(renderings: Sequence[Statistic], count: int, *, seed: int) -> tuple[float, float]:
    """Ends of the 95 % interval of a statistic's mean over independent renderings, NaN where it is never defined.

    Renderings are drawn, and in each drawn one its items. Of what n renderings differ by, drawing among them sees
    (n - 1) / n.
    """
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, count])))

    def drawn() -> float:
        # A single rendering takes nothing from the stream of its items.
        chosen = random.integers(0, len(renderings), len(renderings)) if len(renderings) > 1 else [0]
        return float(np.mean([renderings[number](random.integers(0, count, count)) for number in chosen]))

    return ends(np.array([drawn() for _ in range(RESAMPLES)]))


def resampled(count: int, resamples: int, random: np.random.Generator) -> Index:
    """Numbers of as many items as there are, drawn with replacement, shape (resamples, count)."""
    return random.integers(0, count, (resamples, count))


def ends(values: Array) -> tuple[float, float]:
    """Ends of the interval that resampled values say, those that are not finite left out; NaN twice where none is."""
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan"), float("nan")
    low, high = np.quantile(values, [TAIL, 1 - TAIL])
    return float(low), float(high)


def count_ends(events: int) -> tuple[float, float]:
    """Ends of the exact interval of the expected count, where so many independent events were counted."""
    from scipy.special import gammaincinv

    low = float(gammaincinv(events, TAIL)) if events else 0.0
    return low, float(gammaincinv(events + 1, 1 - TAIL))


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
            found = COMPUTE[name](table, drawn @ member)
        if np.isnan(found).mean() <= MOST_UNDEFINED:
            low, high = ends(found)
    return MeasureEstimate(value=value, low=low, high=high, episodes=len(labels))


def exact_share(successes: int, total: int) -> MeasureEstimate:
    """A share of independent trials, where the bootstrap has nothing to spread once all are alike."""
    if total == 0:
        return MeasureEstimate(value=None, low=None, high=None, episodes=0)
    from scipy.stats import binomtest

    found = binomtest(successes, total).proportion_ci(CONFIDENCE, method="exact")
    return MeasureEstimate(value=successes / total, low=float(found.low), high=float(found.high), episodes=total)
