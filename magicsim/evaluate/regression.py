"""Is a detector worse than the baseline on the same frames? A paired permutation test over episodes.

If nothing had changed, it would not matter which of the two runs of an episode is called the baseline's. So both runs
of each episode are exchanged at random (all 2^n ways where that is feasible), and the observed fall of a measure is
compared with the falls that this gives. The p-values of all measures are corrected after Holm (1979), leaving out the
measures in which too few episodes differ to become significant whatever they say (Tarone 1990). Scores enter as ranks
within their run, because two detectors need not share a scale. A fall counts as a regression where it is significant
and large enough to matter. With n episodes that all fall p is 2^-n: fewer than six can never raise an alarm.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from scipy.stats import permutation_test, rankdata

from magicsim.evaluate.changed_frames import FrameRun, changed_runs
from magicsim.evaluate.intervals import weights_of
from magicsim.evaluate.judged import JudgedEpisode
from magicsim.evaluate.measures import MEASURES
from magicsim.evaluate.tally import Tally, tally

SIGNIFICANCE = 0.05
"""Of all measures together, after Holm."""
EXCHANGES = 9999
"""Random exchanges where all of them are more."""
STANDARD = {
    "proximity_balanced_accuracy": 0.01,
    "contact_balanced_accuracy": 0.01,
    "approach_auc": 0.005,
    "touch_auc": 0.005,
    "light_false_alarms": 0.01,
    "lead_mm": 0.5,
    "onset_mm": 0.02,
}
"""Measures that are compared in the standard condition, and the smallest fall that matters."""
OTHERS = {"proximity_balanced_accuracy": 0.02, "contact_balanced_accuracy": 0.02}
"""The same in every other condition of light and noise."""
ROUNDING = 1e-10
"""Differences of measures below this are rounding."""
Pair = tuple[JudgedEpisode, JudgedEpisode]
Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """How one measure differs from the baseline's on the same frames."""

    condition: str
    measure: str
    baseline: float
    current: float
    fall: float
    """How much worse, positive where it is worse, in the measure's unit."""
    matters: float
    """Smallest fall that matters."""
    episodes: int
    p_fall: float
    """Probability of such a fall if nothing had changed."""
    p_rise: float
    p_least: float
    """Smallest p that so many differing episodes could give."""
    p_fall_corrected: float = 1.0
    p_rise_corrected: float = 1.0
    frames: list[FrameRun] = field(default_factory=list)
    """Frames that tell the two apart, for a change that is reported."""

    @property
    def is_regression(self) -> bool:
        """Whether it is significantly and noticeably worse."""
        return self.fall >= self.matters and self.p_fall_corrected < SIGNIFICANCE

    @property
    def is_improvement(self) -> bool:
        """Whether it is significantly and noticeably better."""
        return -self.fall >= self.matters and self.p_rise_corrected < SIGNIFICANCE


def compare(pairs: Sequence[Pair], conditions: Sequence[str], *, seed: int) -> list[Change]:
    """All compared measures of all conditions, with corrected p-values.

    Args:
        pairs: The same episodes judged before and now.
        conditions: Condition of each pair; that of the first pair is the standard one.
        seed: Of random exchanges.
    """
    changes = []
    for condition in dict.fromkeys(conditions):
        chosen = [pair for pair, one in zip(pairs, conditions, strict=True) if one == condition]
        gates = STANDARD if condition == conditions[0] else OTHERS
        table = _both(chosen)
        changes += [
            change
            for name, matters in gates.items()
            if (change := _change(table, len(chosen), condition, name, matters, seed)) is not None
        ]
    least = [each.p_least for each in changes]
    falls, rises = holm([each.p_fall for each in changes], least), holm([each.p_rise for each in changes], least)
    corrected = [
        replace(each, p_fall_corrected=fall, p_rise_corrected=rise)
        for each, fall, rise in zip(changes, falls, rises, strict=True)
    ]
    return [
        replace(each, frames=_frames(each, pairs, conditions)) if each.is_regression or each.is_improvement else each
        for each in corrected
    ]


def holm(values: Sequence[float], least: Sequence[float]) -> list[float]:
    """p-values corrected for several tests, in the given order.

    Holm's step-down method (1979) on the tests that can reject at all: with K the smallest number for which at most K
    tests can reach a p of `SIGNIFICANCE` / K, only those count (Tarone 1990). The others become 1.

    Args:
        values: One p a test.
        least: Smallest p that a test could have given.
    """
    counted = next(
        (
            able
            for k in range(1, len(values) + 1)
            if len(able := [place for place, p in enumerate(least) if p <= SIGNIFICANCE / k]) <= k
        ),
        [],
    )
    highest, corrected = 0.0, [1.0] * len(values)
    for rank, place in enumerate(sorted(counted, key=lambda each: values[each])):
        highest = max(highest, min(1.0, (len(counted) - rank) * values[place]))
        corrected[place] = highest
    return corrected


def _both(pairs: Sequence[Pair]) -> Tally:
    """Tally of all episodes before, then of all episodes now, scores as ranks within each run."""
    return tally([*_ranked([before for before, _ in pairs]), *_ranked([now for _, now in pairs])])


def _ranked(episodes: Sequence[JudgedEpisode]) -> list[JudgedEpisode]:
    ends = np.cumsum([len(each.approach) for each in episodes])[:-1]
    ranks = {
        name: np.split(rankdata(np.concatenate([getattr(each, name) for each in episodes])), ends)
        for name in ("approach", "touch")
    }
    return [
        replace(each, approach=ranks["approach"][place], touch=ranks["touch"][place])
        for place, each in enumerate(episodes)
    ]


def _change(table: Tally, count: int, condition: str, name: str, matters: float, seed: int) -> Change | None:
    kind = MEASURES[name]
    sign = 1.0 if kind.better == "higher" else -1.0

    def values(indices: npt.NDArray[np.int64]) -> Array:
        weights = weights_of(indices.astype(np.int64), 2 * count)
        return kind.compute(table, weights.reshape(-1, 2 * count)).reshape(indices.shape[:-1])

    def fall(before: npt.NDArray[np.int64], now: npt.NDArray[np.int64], axis: int = -1) -> Array:
        found = sign * (values(np.moveaxis(before, axis, -1)) - values(np.moveaxis(now, axis, -1)))
        return np.asarray(np.round(found, 12))  # sums in another order must compare as equal

    before, now = np.arange(count), np.arange(count, 2 * count)
    old, new = float(values(before[None])[0]), float(values(now[None])[0])
    if np.isnan(old) or np.isnan(new):
        return None
    exchanged = np.tile(now, (count, 1))
    np.fill_diagonal(exchanged, before)
    reverse = np.tile(before, (count, 1))
    np.fill_diagonal(reverse, now)
    differ = int((np.abs(fall(reverse, exchanged) - sign * (old - new)) > ROUNDING).sum())
    p_values = []
    for side in ("greater", "less"):
        if count == 1 or differ == 0:
            p_values.append(1.0)
            continue
        found = permutation_test(
            (before, now), fall, permutation_type="samples", vectorized=True, n_resamples=EXCHANGES, batch=2000,
            alternative=side, rng=np.random.default_rng(seed),
        )  # fmt: skip
        p_values.append(float(found.pvalue))
    return Change(
        condition=condition, measure=name, baseline=old, current=new, fall=sign * (old - new), matters=matters,
        episodes=count, p_fall=p_values[0], p_rise=p_values[1], p_least=0.5**differ,
    )  # fmt: skip


def _frames(change: Change, pairs: Sequence[Pair], conditions: Sequence[str]) -> list[FrameRun]:
    chosen = [pair for pair, one in zip(pairs, conditions, strict=True) if one == change.condition]
    return [run for pair in chosen for run in changed_runs(*pair, change.measure, worse=change.fall > 0)]
