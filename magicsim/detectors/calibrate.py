"""Fits a profile to labelled episodes: thresholds exactly, options from a finite set.

Entropy and correlation depend on the difference blur alone, similarity on tau_b, polarity, measure and grid
blur, so each feature is measured once for each of its own options and every combination is scored from them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import numpy.typing as npt

from magicsim.detectors.features import Episode, Features, measure_brightening, measure_similarity, scored_classes
from magicsim.detectors.profile import DetectorProfile, Polarity, Similarity
from magicsim.detectors.thresholds import COMPARED_DECIMALS, fit_contact, fit_proximity, rest_limit
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass

ALIKE_DECIMALS = 2
"""Accuracies that are equal to so many decimals are alike: a frame or two of a few episodes; margins then decide."""
REST_MARGIN_SD = 4.0
"""Standard deviations between a fitted threshold and an untouched sensor, at least."""
WIDTHS_TO_END = 3.0
"""Logistic widths between a fitted threshold and the end of its measure's range, at least."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """Values to try for each option; every combination is one candidate."""

    tau_b: Sequence[int] = (20, 35, 50, 65, 80, 100)
    """Grey levels that separate grid from background, or per cent of the surroundings' brightness."""
    polarity: Sequence[Polarity] = ("dark", "bright")
    """Sides of tau_b that may be the grid."""
    similarity: Sequence[Similarity] = ("recall", "iou", "dice")
    """Measures of overlap."""
    grid_blur_px: Sequence[int] = (5,)
    """Kernels before binarising [px]."""
    difference_blur_px: Sequence[int] = (0, 5, 9)
    """Kernels before the difference [px]."""
    surround_px: Sequence[int] = (0,)
    """Standard deviations of surroundings [px]; 0 compares with a grey level."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateScore:
    """How well one combination of options does with its best thresholds."""

    profile: DetectorProfile
    """The options with their best thresholds."""
    proximity_accuracy: float
    """Balanced accuracy on the training frames, 0..1."""
    contact_accuracy: float | None
    """Balanced accuracy of the combined verdict, 0..1; None where the references show no grid."""
    proximity_margin: float
    """Smaller of the half gaps around tau_e and tau_c, in standard deviations within classes."""
    contact_margin: float | None
    """Half the gap around tau_g, in standard deviations within classes; None like the accuracy."""
    held_out_accuracy: float | None = None
    """Contact accuracy on episodes that were left out one after the other, their mean; None for one episode, or where
    leaving one out leaves no frame of a class."""

    @property
    def accuracy(self) -> float | None:
        """Mean of both accuracies, which the fit maximises."""
        if self.contact_accuracy is None:
            return None
        return (self.proximity_accuracy + self.contact_accuracy) / 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """A fitted profile and all that was tried."""

    best: CandidateScore
    """The chosen candidate."""
    candidates: tuple[CandidateScore, ...]
    """Every candidate in the order tried."""

    @property
    def profile(self) -> DetectorProfile:
        """The fitted profile, its probabilities as sharp as its thresholds ask for."""
        return sharpen(self.best.profile)


def sharpen(profile: DetectorProfile) -> DetectorProfile:
    """A profile whose probabilities suit thresholds near the end of a measure's range.

    Correlation and similarity end at 1, so a threshold close to 1 leaves no room for the base's widths. They are
    narrowed until a frame at the end of the range is 3 widths, a probability of 0.95, away from the threshold.
    """
    return replace(
        profile,
        correlation_width=min(profile.correlation_width, max(1e-6, (1.0 - profile.tau_c) / WIDTHS_TO_END)),
        similarity_width=min(profile.similarity_width, max(1e-6, (1.0 - profile.tau_g) / WIDTHS_TO_END)),
    )


def fit_profile(
    base: DetectorProfile,
    episodes: Sequence[Episode],
    candidates: Candidates | None = None,
    *,
    margin_sd: float = REST_MARGIN_SD,
    entropy_margin_sd: float | None = None,
) -> Calibration:
    """Choose options and thresholds that maximise the mean of both balanced accuracies on labelled episodes.

    The proximity thresholds come first, with a penalty for Contact frames called Noise; then the contact
    threshold, given what is Noise. Options are compared by contact on episodes that a threshold has not seen, each left
    out once, so that those win whose threshold serves objects and rooms alike. Ties, to a hundredth of each accuracy,
    go to the candidate whose weaker margin is larger, then to the one whose stronger margin is, then to the first. The
    same input gives the same result.

    Args:
        base: Everything that is not fitted: numbers of references, largest widths of the probabilities.
        episodes: Training frames with classes, every class at least once over all episodes.
        candidates: Values to try; the defaults when left out.
        margin_sd: How far tau_e and tau_g stay from the untouched frames of every episode, in standard deviations of
            each: what a camera's own noise does is no event.
        entropy_margin_sd: Of tau_e instead; the same by default. Behind a camera that exposes by itself E at rest
            spreads over bits, and a margin would leave no approach to be told; far below 0 is none.

    Raises:
        ConfigError: A class without frames, no candidates, or no candidate whose references show a grid.
        FrameError: A frame cannot be used.
    """
    if base.units == "rest":
        raise ConfigError("units = 'rest' is not allowed in the base of a fit; must be 'fixed'")
    tried, entropy_sd = candidates or Candidates(), margin_sd if entropy_margin_sd is None else entropy_margin_sd
    classes = scored_classes(episodes)
    missing = [str(each) for each in FrameClass if each not in classes]
    if missing:
        raise ConfigError(f"training episodes hold no frame of class {', '.join(missing)}; every class is needed")
    options = list(product(tried.tau_b, tried.polarity, tried.grid_blur_px, tried.surround_px))
    counts = [len(scored_classes([episode])) for episode in episodes]
    owner, clear = np.repeat(np.arange(len(episodes)), counts), np.array([each is FrameClass.CLEAR for each in classes])
    at_rest = [clear & (owner == number) for number in range(len(episodes))]
    similarities = measure_similarity(episodes, base, options, tried.similarity)
    scores: list[CandidateScore] = []
    for difference_blur_px in tried.difference_blur_px:
        entropy, correlation = measure_brightening(episodes, base, difference_blur_px)
        near = fit_proximity(entropy, correlation, classes, least_tau_e=rest_limit(entropy, at_rest, entropy_sd))
        noise = (entropy >= near.tau_e) & (correlation >= near.tau_c)
        for ((tau_b, polarity, grid_blur_px, surround_px), measure), similarity in similarities.items():
            profile = replace(
                base, tau_e=near.tau_e, tau_c=near.tau_c, tau_b=tau_b, polarity=polarity, similarity=measure,
                grid_blur_px=grid_blur_px, surround_px=surround_px, difference_blur_px=difference_blur_px,
            )  # fmt: skip
            touch, held_out = None, None
            if similarity is not None:
                limit = -rest_limit(-similarity, at_rest, margin_sd)
                touch = fit_contact(similarity, noise, classes, most_tau_g=limit)
                held_out = held_out_accuracy(similarity, noise, classes, owner, at_rest, margin_sd)
            scores.append(
                CandidateScore(
                    profile=profile if touch is None else replace(profile, tau_g=touch.tau_g),
                    proximity_accuracy=near.accuracy,
                    contact_accuracy=None if touch is None else touch.accuracy,
                    proximity_margin=near.margin,
                    contact_margin=None if touch is None else touch.margin,
                    held_out_accuracy=held_out,
                )
            )
    return Calibration(best=_best(scores), candidates=tuple(scores))


def held_out_accuracy(
    similarity: Features,
    noise: npt.NDArray[np.bool_],
    classes: Sequence[FrameClass],
    owner: npt.NDArray[np.int64],
    at_rest: Sequence[npt.NDArray[np.bool_]],
    margin_sd: float,
) -> float | None:
    """Mean over episodes of the contact accuracy with the threshold of all others, None where there is none.

    All arrays have shape (frames,): similarity, whether a frame is called noise, the number of its episode, and for
    each episode which frames show its untouched sensor. The threshold stays `margin_sd` standard deviations from these.
    """
    touched, accuracies = np.array([each is FrameClass.CONTACT for each in classes]), []
    for number in range(len(at_rest)):
        held = owner == number
        if any(not (part & kept).any() for part in (touched, ~touched) for kept in (held, ~held)):
            return None
        rest = [frames[~held] for other, frames in enumerate(at_rest) if other != number]
        limit = -rest_limit(-similarity[~held], rest, margin_sd)
        left = [each for each, is_held in zip(classes, held, strict=True) if not is_held]
        tau_g = fit_contact(similarity[~held], noise[~held], left, most_tau_g=limit).tau_g
        called = (similarity < tau_g) & ~noise
        accuracies.append((called[held & touched].mean() + 1 - called[held & ~touched].mean()) / 2)
    return float(np.mean(accuracies))


def _best(scores: Sequence[CandidateScore]) -> CandidateScore:
    """The candidate with the best accuracy, by margins among equals, and then the first."""
    ranked = [(_rank(each), each) for each in scores if each.accuracy is not None]
    if not ranked:
        msg = f"none of {len(scores)} candidates can be fitted; tau_b and polarity must leave some grid visible"
        raise ConfigError(msg)
    return max(ranked, key=lambda pair: pair[0])[1]


def _rank(each: CandidateScore) -> tuple[float, ...]:
    """What candidates are compared by: accuracies to a hundredth, then weaker margin, stronger margin, accuracy."""
    margins, accuracy = sorted((each.proximity_margin, each.contact_margin or 0.0)), each.accuracy or 0.0
    contact = each.held_out_accuracy if each.held_out_accuracy is not None else each.contact_accuracy or 0.0
    finer = [round(value, COMPARED_DECIMALS) for value in (*margins, accuracy)]
    alike = sum(round(value, ALIKE_DECIMALS) for value in (each.proximity_accuracy, contact))
    return (round(alike, ALIKE_DECIMALS), *finer)
