"""Thresholds that separate labelled features best, and logistic widths that make the probabilities mean something.

A candidate threshold lies in the middle of a gap between neighbouring training values (or between them and
the end of the feature's range), so that a separable pair of classes gets the middle of the gap between them.
Among equally good ones the widest gap wins, measured in standard deviations within the classes.

With a width fitted by maximum likelihood a probability p at some distance from a threshold says that, were both classes
equally frequent, a share p of the training frames at that distance would be positive. The threshold stays, so that p is
one half there and verdicts and probabilities never disagree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.detectors.features import Episode, Features, measure_brightening, measure_similarity, scored_classes
from magicsim.detectors.profile import DetectorProfile
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass

SPREAD_FLOOR = 1e-3
"""Smallest spread that a margin is divided by, in the feature's unit: below it differences are rounding."""
COMPARED_DECIMALS = 9
"""Decimals to which scores and margins are compared, so that rounding decides nothing."""
_ENTROPY_ENDS, _CORRELATION_ENDS, _SIMILARITY_ENDS = (0.0, 8.0), (-1.0, 1.0), (0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProximityFit:
    """The two thresholds of the proximity algorithm."""

    tau_e: float
    tau_c: float
    accuracy: float
    margin: float
    """The smaller of the half gaps that both thresholds lie in, in standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactFit:
    """The threshold of the contact algorithm, and the balanced accuracy of the combined verdict."""

    tau_g: float
    accuracy: float
    margin: float
    """Half the gap that tau_g lies in, in standard deviations."""


def rest_limit(values: Features, at_rest: Sequence[npt.NDArray[np.bool_]], margin_sd: float) -> float:
    """The farthest of several sensors' untouched frames: mean and so many standard deviations, the largest of them.

    Values are a feature of all frames, shape (frames,), or the negative of one that falls; fewer than two frames of a
    sensor at rest say nothing, and negative infinity is returned where nothing is known.
    """
    spreads = [values[each] for each in at_rest if np.count_nonzero(each) > 1]
    return max((float(each.mean() + margin_sd * each.std(ddof=1)) for each in spreads), default=-np.inf)


def fit_proximity(
    entropy: Features, correlation: Features, classes: Sequence[FrameClass], *, least_tau_e: float = -np.inf
) -> ProximityFit:
    """Choose tau_e and tau_c together.

    Maximises the balanced proximity accuracy plus half the share of Contact frames that are not called Noise:
    a Contact frame called Noise is `Unknown`, which counts as untouched and costs that half in the contact
    accuracy. Every pair of candidates is tried. E, C and classes have shape (frames,), every class at least one frame;
    from `least_tau_e` on a brightening is more than the camera's own, see `rest_limit` [bit].
    """
    labels = np.array(classes, dtype=object)
    clear, near, contact, light = (labels == each for each in FrameClass)
    judged_e = clear | near | light
    cuts_e, gaps_e = _allowed(*candidate_cuts(entropy[judged_e], _ENTROPY_ENDS), _ENTROPY_ENDS, least=least_tau_e)
    margins_e = gaps_e / within_spread(entropy, [clear, near | light])
    fits: list[tuple[tuple[float, ...], ProximityFit]] = []
    for tau_e, margin_e in zip(cuts_e, margins_e, strict=True):
        rises = entropy >= tau_e
        judged_c = rises & ~clear
        cuts_c, gaps_c = candidate_cuts(correlation[judged_c], _CORRELATION_ENDS)
        spread = within_spread(correlation, [rises & (near | contact), rises & light])
        accuracy = (
            np.mean(entropy[clear] < tau_e)
            + share_below(correlation[near & rises], cuts_c, int(near.sum()))
            + share_from(correlation[light & rises], cuts_c, int(light.sum()))
        ) / 3.0
        kept = 1.0 - share_from(correlation[contact & rises], cuts_c, int(contact.sum()))
        scores, margins_c = accuracy + kept / 2.0, gaps_c / spread
        chosen = _first_best(scores, margins_c)
        weaker, stronger = sorted((float(margin_e), float(margins_c[chosen])))
        key = tuple(round(each, COMPARED_DECIMALS) for each in (float(scores[chosen]), weaker, stronger))
        values = {"tau_e": tau_e, "tau_c": cuts_c[chosen], "accuracy": accuracy[chosen], "margin": weaker}
        fits.append((key, ProximityFit(**{name: float(each) for name, each in values.items()})))
    return max(fits, key=lambda keyed: keyed[0])[1]


def fit_contact(
    similarity: Features, noise: npt.NDArray[np.bool_], classes: Sequence[FrameClass], *, most_tau_g: float = np.inf
) -> ContactFit:
    """Choose tau_g, given which frames proximity calls Noise (those are never `Touched`).

    S, noise and classes have shape (frames,); Contact and another class have at least one frame. The camera's own noise
    reaches down to `most_tau_g`, see `rest_limit`.
    """
    labels = np.array(classes, dtype=object)
    touched = labels == FrameClass.CONTACT
    cuts, gaps = _allowed(*candidate_cuts(similarity[~noise], _SIMILARITY_ENDS), _SIMILARITY_ENDS, most=most_tau_g)
    margins = gaps / within_spread(similarity, [touched & ~noise, ~touched & ~noise])
    hits = share_below(similarity[touched & ~noise], cuts, int(touched.sum()))
    false_alarms = share_below(similarity[~touched & ~noise], cuts, int((~touched).sum()))
    accuracy = (hits + 1.0 - false_alarms) / 2.0
    chosen = _first_best(accuracy, margins)
    return ContactFit(tau_g=float(cuts[chosen]), accuracy=float(accuracy[chosen]), margin=float(margins[chosen]))


def candidate_cuts(values: Features, ends: tuple[float, float]) -> tuple[Features, Features]:
    """Middles and half widths of the gaps between neighbouring values and the ends of their range."""
    edges = np.unique(np.concatenate([values, ends]))
    return (edges[:-1] + edges[1:]) / 2.0, np.diff(edges) / 2.0


def _allowed(
    cuts: Features, gaps: Features, ends: tuple[float, float], *, least: float = -np.inf, most: float = np.inf
) -> tuple[Features, Features]:
    """Cuts between two limits; where none is, the limit itself, or the end of the range if that lies before it."""
    inside = (cuts >= least) & (cuts <= most)
    if inside.any():
        return cuts[inside], gaps[inside]
    return np.clip([least if np.isfinite(least) else most], *ends), np.zeros(1)


def within_spread(values: Features, groups: Sequence[npt.NDArray[np.bool_]]) -> float:
    """Root mean square of the standard deviations of groups that have members, at least `SPREAD_FLOOR`."""
    variances = [float(np.var(values[group])) for group in groups if group.any()]
    return max(SPREAD_FLOOR, float(np.sqrt(np.mean(variances))) if variances else 0.0)


def share_below(values: Features, cuts: Features, total: int) -> Features:
    """Share of `total` frames whose value lies below each cut, shape (cuts,)."""
    return np.searchsorted(np.sort(values), cuts, side="left") / total


def share_from(values: Features, cuts: Features, total: int) -> Features:
    """Share of `total` frames whose value is at or above each cut, shape (cuts,)."""
    return len(values) / total - share_below(values, cuts, total)


def _first_best(scores: Features, margins: Features) -> int:
    """Index of the best score, by margin among equals, and then the first."""
    rounded = np.round(scores, COMPARED_DECIMALS)
    tied = np.flatnonzero(rounded == rounded.max())
    return int(tied[np.argmax(np.round(margins[tied], COMPARED_DECIMALS))])


Mask = npt.NDArray[np.bool_]
"""Which scored frames belong to a group, shape (frames,)."""
NARROWEST = 1e-6
"""Smallest width, in the feature's unit: the smallest that a profile may have."""
_HALVINGS = 200


def fit_widths(profile: DetectorProfile, episodes: Sequence[Episode]) -> DetectorProfile:
    """The profile with the three widths fitted, each with its threshold held.

    Entropy tells Near and Light frames from Clear ones, correlation Light from Near and Contact ones, and similarity
    Contact frames from all others, Noise left out.

    `ConfigError` where a class has no frames, or references show no grid.
    """
    labels = np.array(scored_classes(episodes), dtype=object)
    clear, near, contact, light = (labels == each for each in FrameClass)
    missing = [str(each) for each in FrameClass if each not in labels]
    option = (profile.tau_b, profile.polarity, profile.grid_blur_px, profile.surround_px)
    if missing:
        raise ConfigError(f"training episodes hold no frame of class {', '.join(missing)}; every class is needed")
    similarity = measure_similarity(episodes, profile, [option], [profile.similarity])[option, profile.similarity]
    if similarity is None:
        raise ConfigError(f"the references show no grid with tau_b = {profile.tau_b} and polarity '{profile.polarity}'")
    entropy, correlation = measure_brightening(episodes, profile, profile.difference_blur_px)
    dark = (entropy < profile.tau_e) | (correlation < profile.tau_c)
    e, c, s = entropy - profile.tau_e, correlation - profile.tau_c, profile.tau_g - similarity
    return replace(
        profile,
        entropy_width=_width(e, near | light, clear, profile.entropy_width, widest=8.0),
        correlation_width=_width(c, light, near | contact, profile.correlation_width, widest=2.0),
        similarity_width=_width(s, contact & dark, ~contact & dark, profile.similarity_width, widest=1.0),
    )


def _width(distances: Features, positive: Mask, negative: Mask, otherwise: float, *, widest: float) -> float:
    """The fitted width, or the old one where a group has no frames."""
    both = positive.any() and negative.any()
    return logistic_width(distances[positive], distances[negative], widest=widest) if both else otherwise


def logistic_width(positive: npt.ArrayLike, negative: npt.ArrayLike, *, widest: float) -> float:
    """Width w that makes 1 / (1 + exp(-d / w)) most likely, both classes weighing the same.

    The cross-entropy is convex in 1 / w, whose derivative is bisected. Its targets are those of Platt (1999), (n + 1) /
    (n + 2) for n positives and 1 / (m + 2) for m negatives, so that separable classes have a width too. d are distances
    from the threshold, shape (n,), mostly above 0, and (m,), mostly below; the width is `widest` where they speak
    against their classes.
    """
    groups = [np.asarray(each, dtype=np.float64) for each in (positive, negative)]
    targets = [(len(groups[0]) + 1) / (len(groups[0]) + 2), 1 / (len(groups[1]) + 2)]

    def slope(inverse: float) -> float:
        return sum(
            float(np.mean((0.5 * (1.0 + np.tanh(0.5 * each * inverse)) - target) * each))
            for each, target in zip(groups, targets, strict=True)
        )

    low, high = 1 / widest, 1 / NARROWEST
    if slope(low) >= 0:
        return widest
    if slope(high) <= 0:
        return NARROWEST
    for _ in range(_HALVINGS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if slope(middle) < 0 else (low, middle)
    return min(widest, max(NARROWEST, 1 / float(np.sqrt(low * high))))
