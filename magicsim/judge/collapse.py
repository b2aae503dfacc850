"""A detector that tells nothing apart: a class that it never names, or a balanced accuracy by chance.

This needs no baseline and no test. A verdict that is always given leaves the other classes without theirs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from magicsim.detectors.verdict import Contact
from magicsim.frame_class import FrameClass
from magicsim.judge.intervals import MeasureEstimate
from magicsim.judge.measures import TABLE, UNTOUCHED, measure
from magicsim.judge.score import PROXIMITY_TRUTH
from magicsim.judge.tally import JudgedEpisode, tally

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

    Args:
        episodes: Those of the standard condition.
        estimates: Measures of them.
        before: Episodes of the standard condition as the baseline's detector judged them.
        coated: Behind an opaque coat nothing is known of proximity.
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
