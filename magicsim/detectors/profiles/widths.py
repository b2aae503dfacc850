"""Logistic widths that make the probabilities mean something: fitted to labelled frames by maximum likelihood.

With a fitted width a probability p at some distance from a threshold says that, were both classes equally frequent, a
share p of the training frames at that distance would be positive. The threshold stays, so that p is one half there and
verdicts and probabilities never disagree.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.scoring.episode import (
    Episode,
    Features,
    measure_brightening,
    measure_similarity,
    scored_classes,
)
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass

Mask = npt.NDArray[np.bool_]
"""Which scored frames belong to a group, shape (frames,)."""

NARROWEST = 1e-6
"""Smallest width, in the feature's unit: the smallest that a profile may have."""

_HALVINGS = 200


def fit_widths(profile: DetectorProfile, episodes: Sequence[Episode]) -> DetectorProfile:
    """The profile with the three widths fitted, each with its threshold held.

    Entropy tells Near and Light frames from Clear ones, correlation Light from Near and Contact ones, and similarity
    Contact frames from all others, Noise left out.

    Args:
        profile: Thresholds and options.
        episodes: Labelled frames, every class at least once.

    Raises:
        ConfigError: A class without frames, or the references show no grid.
        FrameError: A frame cannot be used.
    """
    labels = np.array(scored_classes(episodes), dtype=object)
    clear, near, contact, light = (labels == each for each in FrameClass)
    missing = [str(each) for each in FrameClass if each not in labels]
    option = (profile.tau_b, profile.polarity, profile.grid_blur_px, profile.surround_px)
    if missing:
        msg = f"training episodes hold no frame of class {', '.join(missing)}; every class is needed"
        raise ConfigError(msg)
    similarity = measure_similarity(episodes, profile, [option], [profile.similarity])[option, profile.similarity]
    if similarity is None:
        msg = f"the references show no grid with tau_b = {profile.tau_b} and polarity '{profile.polarity}'"
        raise ConfigError(msg)
    entropy, correlation = measure_brightening(episodes, profile, profile.difference_blur_px)
    dark = (entropy < profile.tau_e) | (correlation < profile.tau_c)
    return replace(
        profile,
        entropy_width=_width(entropy - profile.tau_e, near | light, clear, profile.entropy_width, widest=8.0),
        correlation_width=_width(
            correlation - profile.tau_c, light, near | contact, profile.correlation_width, widest=2.0
        ),
        similarity_width=_width(
            profile.tau_g - similarity, contact & dark, ~contact & dark, profile.similarity_width, widest=1.0
        ),
    )


def _width(distances: Features, positive: Mask, negative: Mask, otherwise: float, *, widest: float) -> float:
    """The fitted width, or the old one where a group has no frames."""
    if not positive.any() or not negative.any():
        return otherwise
    return logistic_width(distances[positive], distances[negative], widest=widest)


def logistic_width(positive: npt.ArrayLike, negative: npt.ArrayLike, *, widest: float) -> float:
    """Width w that makes 1 / (1 + exp(-d / w)) most likely, both classes weighing the same.

    The cross-entropy is convex in 1 / w, whose derivative is bisected. Its targets are those of Platt (1999),
    (n + 1) / (n + 2) for n positives and 1 / (m + 2) for m negatives, so that separable classes have a width too.

    Args:
        positive: Distances d of positive frames from the threshold, mostly above 0, shape (n,).
        negative: Those of negative frames, mostly below 0, shape (m,).
        widest: Largest width; the result when distances speak against their classes.
    """
    groups = [np.asarray(each, dtype=np.float64) for each in (positive, negative)]
    targets = [(len(groups[0]) + 1) / (len(groups[0]) + 2), 1 / (len(groups[1]) + 2)]

    def slope(inverse: float) -> float:
        return sum(
            float(np.mean((_logistic(each * inverse) - target) * each))
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


def _logistic(distances: Features) -> Features:
    return 0.5 * (1.0 + np.tanh(0.5 * distances))
