"""Is a detector worse than the baseline on the same frames? A paired permutation test over takes.

If nothing had changed, it would not matter which of the two runs of a take is called the baseline's. So both runs of
each take, with all its noises, are exchanged (all 2^n ways where that is feasible), and the observed fall of a measure
is compared with the falls that this gives, corrected for all measures together (Westfall and Young 1993, step-down
minima of p-values): both runs of a unit are exchanged together in every measure, so the correction knows how the
measures hang together, and measures that fall together count as one, where Bonferroni or Holm would ask each to pay for
the others. A fall counts as a regression where it is significant and large enough to matter. With n takes that all fall
p is 2^-n: fewer than five can never show a fall by this test. So every measure says from which one on it would have.

Areas under the curve take scores as ranks within their run, because two detectors need not share a scale. A detector
that is compared with its own former self does, and then the mean scores of each class are compared as well: where
margins are wide, a threshold that moved changes no verdict and no rank, but it takes from the margin on one of its
sides. The frames are the same and a mean over them has no sampling error but camera noise, which is far below what
matters; so no take has to agree with the others, and no p-value is asked for.

A detector that tells nothing apart needs neither baseline nor test: a class that it never names, or a balanced accuracy
by chance.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from scipy.stats import rankdata

from magicsim.arrays import Array, Mask
from magicsim.detectors.verdict import Contact
from magicsim.frame_class import FrameClass
from magicsim.judge.changed_frames import FrameRun, changed_runs, score_runs
from magicsim.judge.measures import COMPUTE, SCORE_MEANS, TABLE, UNTOUCHED, MeasureEstimate, measure
from magicsim.judge.score import PROXIMITY_TRUTH
from magicsim.judge.tally import SCORES, JudgedEpisode, Tally, score_pairs, tally

CHANCE = {"proximity_balanced_accuracy": 1 / len(PROXIMITY_TRUTH), "contact_balanced_accuracy": 1 / 2}
"""Balanced accuracies of a detector whose verdicts do not depend on the frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Collapse:
    """What a detector does not tell apart."""

    of: str
    """The class that is never named, `Untouched`, or the measure that is by chance."""
    says: str
    """One line with class, verdict and counts."""
    is_known: bool = False
    """Whether the baseline on the same frames has it too, which is then no regression."""


def collapses(
    episodes: Sequence[JudgedEpisode], estimates: Mapping[str, MeasureEstimate],
    before: Sequence[JudgedEpisode] = (), *, coated: bool = False,
) -> list[Collapse]:  # fmt: skip
    """What collapsed.

    A balanced accuracy is by chance where its interval (its value, without one) does not lie above chance, and known
    where that interval also has the baseline's value in it or above it: what differs may then be chance as well.

    Behind an opaque coat nothing is known of proximity.
    """
    known = _unnamed(before, coated=coated)
    found = [Collapse(of=of, says=says, is_known=of in known) for of, says in _unnamed(episodes, coated=coated).items()]
    for name, chance in CHANCE.items():
        value, low, high = (getattr(estimates[name], end) for end in ("value", "low", "high"))
        if value is None or (value if low is None else low) > chance:
            continue
        former = measure(name, tally(before)) if before else None
        interval = "" if low is None else f" ({100 * low:.1f} to {100 * high:.1f})"
        says = f"{TABLE[name].title} {100 * value:.1f} %{interval}, which is not above chance, {100 * chance:.1f} %"
        is_known = former is not None and former <= (value if high is None else high)
        found.append(Collapse(of=name, says=says, is_known=is_known))
    return found


def _unnamed(episodes: Sequence[JudgedEpisode], *, coated: bool) -> dict[str, str]:
    """Classes that have frames of which none is named rightly, with what is said of them."""
    if not episodes:
        return {}
    count = {kind: int(numbers.sum()) for kind, numbers in tally(episodes).count.items()}
    names = [*([] if coated else PROXIMITY_TRUTH.items()), (FrameClass.CONTACT, Contact.TOUCHED)]
    found = {
        str(truth): f"{truth} is never named {verdict}: 0 of {count[truth]} frames"
        for truth, verdict in names
        if count[truth] and not count[f"{truth} said {verdict}"]
    }
    frames = sum(count[each] for each in UNTOUCHED)
    if frames and frames == sum(count[f"{each} said {Contact.TOUCHED}"] for each in UNTOUCHED):
        found[str(Contact.UNTOUCHED)] = f"{Contact.TOUCHED} is always said: in {frames} of {frames} untouched frames"
    return found


EXCHANGES = 8192
"""Exchanges that are tried: all of them up to 13 units, as many random ones beyond."""
DECIMALS = 10
"""To which statistics are compared: sums in another order must compare as equal."""


def exchanges(units: int, *, seed: int) -> Mask:
    """Which units are exchanged, shape (exchanges, units); the first row, what was observed, exchanges none."""
    if 2**units <= EXCHANGES:
        return np.array(list(product([False, True], repeat=units)), bool).reshape(-1, units)
    drawn = np.random.default_rng(seed).random((EXCHANGES, units)) < 0.5  # noqa: PLR2004
    drawn[0] = False
    return drawn


def p_values(statistics: Array) -> Array:
    """Share of exchanges with a statistic at least as large, shape (exchanges, measures), in 0..1."""
    rounded = np.round(statistics, DECIMALS)
    columns = [1 - np.searchsorted(np.sort(column), column, side="left") / len(column) for column in rounded.T]
    return np.stack(columns, axis=1) if columns else np.empty(statistics.shape)


def corrected(p: Array) -> Array:
    """p-values of the observed row, corrected for all measures together, shape (measures,).

    The smallest one is compared with the smallest of all measures in every exchange, the next with the smallest of all
    but the first, and so on; none becomes smaller than the one before (Ge, Dudoit and Speed 2003).
    """
    order = np.argsort(p[0], kind="stable")
    result, highest = np.ones(p.shape[1]), 0.0
    for rank, place in enumerate(order):
        least = p[:, order[rank:]].min(axis=1)
        highest = max(highest, float((least <= p[0, place] + 10.0**-DECIMALS).mean()))
        result[place] = highest
    return result


SIGNIFICANCE = 0.05
"""Level of all measures together, after correction."""


def smallest_falls(statistics: Array, exchanged: Array) -> Array:
    """Smallest falls that would have been significant, shape (measures,); infinite where none would.

    All takes are to fall by d on average, with the scatter between takes that was observed; the other measures stay.
    Where a share s of the takes is exchanged, the statistic T_s becomes T_s + (d - T_0) (1 - 2s), which reaches the
    unexchanged one's d up to d_s = T_0 - (T_0 - T_s) / 2s. So d has p = (exchanges with d_s >= d) / (all of them): the
    test is inverted, and T_0 less the result is its lower confidence limit (Garthwaite 1996, Biometrics 52:1387). This
    is exact for means of takes and linear in the exchanges for ratios. Corrected for all measures in one step: an
    exchange counts also where another measure has a p at most as small. `statistics` are falls, shape (exchanges,
    measures), of which the first row exchanges none, `exchanged` the shares of episodes that are exchanged, in 0..1.
    """
    p, count = p_values(statistics), len(statistics)
    result = np.full(statistics.shape[1], np.inf)
    for place, (column, share) in enumerate(zip(statistics.T, exchanged.T, strict=True)):
        reached = np.full(count, np.inf)
        np.divide(column - column[0], 2 * share, out=reached, where=share > 0)
        reached += column[0]
        order = np.argsort(-reached, kind="stable")
        entered = np.round(np.delete(p, place, axis=1).min(axis=1, initial=1.0) * count).astype(int)
        entered[order] = np.minimum(entered[order], np.arange(1, count + 1))
        most = int(np.sort(entered)[math.ceil(SIGNIFICANCE * count) - 1]) - 1  # exchanges that may reach d
        if most > 0:
            result[place] = reached[order[most]]
    return result


SCALES = {"approach": ("near_score", "clear_score"), "touch": ("contact_score", "untouched_score")}
"""The two mean scores whose distance is the scale of each score."""
Pair = tuple[JudgedEpisode, JudgedEpisode]


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
    smallest_fall: float | None = None
    """Smallest fall, common to all takes, that would have been a regression, see `smallest_falls`; None for none."""
    p_fall: float | None = None
    """Probability of such a fall if nothing had changed; None for mean scores, which are compared as they are."""
    p_rise: float | None = None
    p_fall_corrected: float | None = None
    p_rise_corrected: float | None = None
    frames: list[FrameRun] = field(default_factory=list)
    """Frames that tell the two apart, for a change that is reported."""

    @property
    def is_regression(self) -> bool:
        """Whether it is significantly and noticeably worse."""
        return self.fall >= self.matters and (self.p_fall_corrected is None or self.p_fall_corrected < SIGNIFICANCE)

    @property
    def is_improvement(self) -> bool:
        """Whether it is significantly and noticeably better."""
        return -self.fall >= self.matters and (self.p_rise_corrected is None or self.p_rise_corrected < SIGNIFICANCE)


def compare(
    pairs: Sequence[Pair], conditions: Sequence[str], *, standard: str, seed: int, same_scale: bool = False
) -> list[Change]:
    """All compared measures of all conditions, with corrected p-values; in the standard one smaller changes matter."""
    changes = _tested(pairs, conditions, standard=standard, seed=seed)
    chosen = [pair for pair, one in zip(pairs, conditions, strict=True) if one == standard]
    if same_scale and chosen:
        changes += _scores(chosen, standard)
    return [
        replace(each, frames=_frames(each, pairs, conditions)) if each.is_regression or each.is_improvement else each
        for each in changes
    ]


def _tested(pairs: Sequence[Pair], conditions: Sequence[str], *, standard: str, seed: int) -> list[Change]:
    """Measures whose change is tested over takes."""
    takes = list(dict.fromkeys(now.tag.take for _, now in pairs))
    tried = exchanges(len(takes), seed=seed)
    changes: list[Change] = []
    falls: list[Array] = []
    exchanged: list[Array] = []
    for condition in dict.fromkeys(conditions):
        chosen = [pair for pair, one in zip(pairs, conditions, strict=True) if one == condition]
        table = _both(chosen)
        mixed = tried[:, [takes.index(now.tag.take) for _, now in chosen]]
        for name, kind in TABLE.items():
            matters = kind.matters if condition == standard else kind.matters_elsewhere
            if matters is None or name in SCORE_MEANS:
                continue
            old, new = _values(table, name, mixed), _values(table, name, ~mixed)
            if np.isnan(old).any() or np.isnan(new).any():
                continue
            falls.append((old - new) * _sign(name))
            exchanged.append(mixed.mean(axis=1))
            changes.append(
                Change(
                    condition=condition, measure=name, baseline=float(old[0]), current=float(new[0]),
                    fall=float(falls[-1][0]), matters=matters, episodes=len(chosen),
                )
            )  # fmt: skip
    if not changes:
        return []
    statistics = np.stack(falls, axis=1)
    fell, rose = p_values(statistics), p_values(-statistics)
    least = smallest_falls(statistics, np.stack(exchanged, axis=1))
    return [
        replace(
            each, p_fall=float(a), p_rise=float(b), p_fall_corrected=float(c), p_rise_corrected=float(d),
            smallest_fall=max(float(e), each.matters) if np.isfinite(e) else None,
        )
        for each, a, b, c, d, e in zip(changes, fell[0], rose[0], corrected(fell), corrected(rose), least, strict=True)
    ]  # fmt: skip


def _scores(pairs: Sequence[Pair], condition: str) -> list[Change]:
    """Mean scores by class; none where the baseline's do not tell the classes apart."""
    before, now = tally([one for one, _ in pairs]), tally([one for _, one in pairs])
    changes = []
    for name, (score, _) in SCORE_MEANS.items():
        high, low = SCALES[score]
        old, new, top, bottom = measure(name, before), measure(name, now), measure(high, before), measure(low, before)
        if old is None or new is None or top is None or bottom is None or top <= bottom:
            continue
        least = (TABLE[name].matters or 0) * (top - bottom)
        changes.append(
            Change(
                condition=condition, measure=name, baseline=old, current=new, fall=(old - new) * _sign(name),
                matters=least, episodes=len(pairs), smallest_fall=least,
            )
        )  # fmt: skip
    return changes


def _sign(name: str) -> float:
    """1 for measures that are good when high, else -1."""
    return 1.0 if TABLE[name].better == "higher" else -1.0


def _both(pairs: Sequence[Pair]) -> Tally:
    """Tally of all episodes before, then of all episodes now; pairs of scores as ranks within each run."""
    before, now = [one for one, _ in pairs], [one for _, one in pairs]
    return replace(tally([*before, *now]), pairs=score_pairs([*_ranked(before), *_ranked(now)]))


def _ranked(episodes: Sequence[JudgedEpisode]) -> list[JudgedEpisode]:
    ends = np.cumsum([len(each.approach) for each in episodes])[:-1]
    ranks = [np.split(rankdata(np.concatenate([getattr(each, name) for each in episodes])), ends) for name in SCORES]
    return [replace(each, approach=near, touch=touch) for each, near, touch in zip(episodes, *ranks, strict=True)]


def _values(table: Tally, name: str, from_now: Mask) -> Array:
    """A measure of episodes taken from before or from now, shape (exchanges,)."""
    return COMPUTE[name](table, np.concatenate([~from_now, from_now], axis=1).astype(np.float64))


def _frames(change: Change, pairs: Sequence[Pair], conditions: Sequence[str]) -> list[FrameRun]:
    chosen = [pair for pair, one in zip(pairs, conditions, strict=True) if one == change.condition]
    if change.measure in SCORE_MEANS:
        least = change.matters
        return [run for pair in chosen for run in score_runs(*pair, change.measure, worse=change.fall > 0, least=least)]
    return [run for pair in chosen for run in changed_runs(*pair, change.measure, worse=change.fall > 0)]
