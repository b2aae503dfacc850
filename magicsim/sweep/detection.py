"""A detector of its own for every design: how well it tells light touches, how fast S falls, how far it sees.

Thresholds are fitted on some of the film and judged on the rest: the lightest touches against an object close by,
outside light and nothing at all, at places that the detector was not calibrated on. With the camera's noise alone every
touch would be told from them; lights that are not as strong as when the detector was calibrated are what makes it
hard.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Mask
from magicsim.camera.camera import Camera
from magicsim.detectors.calibrate import Candidates, fit_profile
from magicsim.detectors.combined import detect_all
from magicsim.detectors.features import Episode
from magicsim.detectors.frame import Frame
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import References, fuse
from magicsim.detectors.verdict import Contact, Verdict
from magicsim.frame_class import NEAR_MAX_MM, FrameClass
from magicsim.judge.curves import roc_curve
from magicsim.judge.measures import interval
from magicsim.sweep.film import REFERENCES, SPAN, DesignFilm, Shown
from magicsim.sweep.measures import Measured

TRAINING_DRAWS = 2
"""Frames of each state that the fit sees."""
CLEAR_DRAWS = 12
"""Frames of the untouched sensor that it sees."""
FULL_PIXELS = 240 * 320
"""Pixels of the image that the published kernels are for."""
TRAINING, TEST = 0, 1
"""Every second place, and every second place of the outside light, trains; the others test."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedDetector:
    """A design's own profile with its references."""

    profile: DetectorProfile
    references: References

    def verdicts(self, frames: Sequence[Frame]) -> list[Verdict]:
        """What it says of frames."""
        return detect_all(frames, self.references, self.profile)

    def features(self, frames: Sequence[Frame]) -> npt.NDArray[np.float64]:
        """Entropy, correlation and similarity, shape (frames, 3)."""
        return np.array([[each.entropy, each.correlation, each.similarity] for each in self.verdicts(frames)])


def fit_detector(film: DesignFilm) -> FittedDetector:
    """Fits thresholds and options to the training part of a film.

    `published` gives what is not fitted, its kernel as large on the face as in a whole image.

    Raises:
        ConfigError: No option leaves a grid to be seen.
    """
    start = load_profile("published")
    size = kernel_px(start.grid_blur_px, film.camera)
    kernels = sorted({0, kernel_px(5, film.camera), kernel_px(9, film.camera)})
    candidates = Candidates(grid_blur_px=(size,), difference_blur_px=kernels)
    references = film.references()
    profile = fit_profile(start, [training_episode(film, references)], candidates).profile
    return FittedDetector(profile=profile, references=fuse(references, profile))


def training_episode(film: DesignFilm, references: Sequence[Frame]) -> Episode:
    """Labelled frames of every class: every second place, and states on the axis."""
    clear = film.frames(film.untouched, CLEAR_DRAWS)
    near = [each for each in film.approach if each.gap_mm is not None and 0 < each.gap_mm <= NEAR_MAX_MM]
    groups: list[tuple[FrameClass, Sequence[Shown]]] = [
        (FrameClass.NEAR, [*film.near[TRAINING::2], *near]),
        (FrameClass.CONTACT, [*film.light_touches[TRAINING::2], *film.touches[TRAINING::2]]),
        (FrameClass.LIGHT, film.light[TRAINING::2]),
    ]
    frames, classes = list(clear), [FrameClass.CLEAR] * len(clear)
    for kind, states in groups:
        for shown in states:
            frames += film.frames(shown, TRAINING_DRAWS)
            classes += [kind] * TRAINING_DRAWS
    return Episode(references=references, frames=frames, classes=classes)


def fixed_detector(film: DesignFilm) -> FittedDetector:
    """A detector with one set of options for every design, so that their similarities can be compared.

    Bright pixels are the grid from the mean grey level upwards, and the overlap is intersection over union: half of the
    pixels lie on each side of the threshold, and whatever moves or changes brightness shows.
    """
    profile = replace(
        load_profile("published"),
        tau_b=round(film.camera.exposure_grey),
        polarity="bright",
        similarity="iou",
        grid_blur_px=kernel_px(5, film.camera),
    )
    return FittedDetector(profile=profile, references=fuse(film.references(), profile))


def kernel_px(full_px: int, camera: Camera) -> int:
    """An odd kernel for a smaller image that covers about as much of the face [px]; 0 where that is no pixel."""
    share = math.sqrt(camera.columns * camera.rows / FULL_PIXELS)
    size = 2 * round((full_px * share - 1) / 2) + 1
    return size if size > 1 else 0


TEST_FIRST = 100
"""First noise stream of the test, beyond those of the training."""
MOST_CLEAR = SPAN - REFERENCES - TEST_FIRST
"""Most untouched frames of the test: the streams after them are the references'."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactScores:
    """Similarities at the test's places, and whether the combined verdict is Touched; shape (places, draws) each.

    Untouched frames, `clear`, have no place: shape (frames,).
    """

    touched: Array
    near: Array
    clear: Array
    hit: Mask
    near_alarm: Mask
    light_alarm: Mask
    clear_alarm: Mask


def contact_scores(
    film: DesignFilm, detector: FittedDetector, draws: int, *, drift: float, touches: Sequence[Shown] | None = None
) -> ContactScores:
    """Similarity and verdict of every test frame, under lights that have drifted (see `Film.frames`).

    Touches are the lightest ones by default.
    """

    def seen(states: Sequence[Shown]) -> tuple[Array, Mask]:
        rows = [detector.verdicts(film.frames(each, draws, first=TEST_FIRST, drift=drift)) for each in states]
        called = [[each.combined is Contact.TOUCHED for each in row] for row in rows]
        return np.array([[each.similarity for each in row] for row in rows]), np.array(called)

    touched, hit = seen((film.light_touches if touches is None else touches)[TEST::2])
    near, near_alarm = seen(film.near[TEST::2])
    _, light_alarm = seen(film.light[TEST::2])
    count = min(draws * len(touched), MOST_CLEAR)
    clear = detector.verdicts(film.frames(film.untouched, count, first=TEST_FIRST, drift=drift))
    clear_alarm = np.array([each.combined is Contact.TOUCHED for each in clear])
    return ContactScores(
        touched=touched, near=near, clear=np.array([each.similarity for each in clear]), hit=hit,
        near_alarm=near_alarm, light_alarm=light_alarm, clear_alarm=clear_alarm,
    )  # fmt: skip


def contact_auc(renderings: Sequence[ContactScores], *, seed: int) -> Measured:
    """Area under the ROC curve of the similarity, touched against near and untouched; mean over renderings.

    Outside light is none of it: it lowers the similarity more than any touch does, and only both algorithms together
    tell it from one.
    """
    return Measured.mean_over([partial(_area, scores) for scores in renderings], len(renderings[0].touched), seed=seed)


def contact_accuracy(renderings: Sequence[ContactScores], *, seed: int) -> Measured:
    """Balanced accuracy of the combined verdict, alarms mean over what is no touch; mean over renderings."""
    accuracies = [partial(_accuracy, scores) for scores in renderings]
    return Measured.mean_over(accuracies, len(renderings[0].touched), seed=seed)


def _area(scores: ContactScores, places: Index) -> float:
    positive = scores.touched[places].ravel()
    negative = np.concatenate([scores.near[places].ravel(), scores.clear])
    labels = np.arange(len(positive) + len(negative)) < len(positive)
    return roc_curve(-np.concatenate([positive, negative]), labels).area


def _accuracy(scores: ContactScores, places: Index) -> float:
    alarms = [each.mean() for each in (scores.near_alarm[places], scores.light_alarm, scores.clear_alarm)]
    return float(scores.hit[places].mean() + 1 - np.mean(alarms)) / 2


FALSE_ALARMS = 0.05
"""Share of untouched frames that are called Approaching."""
CLEAR_FRAMES = 120
"""Untouched frames that set the threshold for it."""
CLEAR_FIRST = 200
"""Their first noise stream, beyond those of the detector's training."""
DETECTED = 0.5
"""Share of frames that makes an object noticed."""
EVERY = slice(None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ApproachCurve:
    """What one rendering of an approach looks like to a detector; all of shape (gaps,) or (gaps, draws)."""

    gaps_mm: Array
    """Falling."""
    entropy: Array
    correlation: Array
    clear_entropy: Array
    """Entropy of untouched frames, shape (frames,)."""
    tau_c: float

    def rates(self, draws: Index | slice = EVERY, clear: Index | slice = EVERY) -> Array:
        """Share of some or all frames called Approaching at each gap, the threshold set on some or all clear ones."""
        tau_e = np.quantile(self.clear_entropy[clear], 1 - FALSE_ALARMS)
        seen = (self.entropy > tau_e) & (self.correlation < self.tau_c)
        return np.asarray(seen[:, draws].mean(1))


def mean_similarity(shown: Sequence[Shown], film: DesignFilm, detector: FittedDetector, draws: int) -> Array:
    """Similarity of some states, mean over the camera's noise, shape (states,)."""
    return np.array([detector.features(film.frames(each, draws))[:, 2].mean() for each in shown])


def contact_sensitivity(light: Array, firm: Array, *, step: float, seed: int) -> Measured:
    """Loss of similarity between two light touches, mean over renderings and places.

    Places differ by how the contact lies on the grid, which is more than the camera's noise. Similarities have shape
    (renderings, places); `step` is what the touches differ by, in depth [mm] or force [N].
    """
    slopes = (light - firm) / step

    def mean(values: Array, places: Index) -> float:
        return float(values[places].mean())

    return Measured.mean_over([partial(mean, each) for each in slopes], slopes.shape[1], seed=seed)


def approach_curve(film: DesignFilm, detector: FittedDetector, draws: int) -> ApproachCurve:
    """Features of the approach and of untouched frames."""
    seen = np.stack([detector.features(film.frames(shown, draws)) for shown in film.approach])
    clear = detector.features(film.frames(film.untouched, CLEAR_FRAMES, first=CLEAR_FIRST))
    return ApproachCurve(
        gaps_mm=np.array([shown.gap_mm for shown in film.approach], float),
        entropy=seen[..., 0],
        correlation=seen[..., 1],
        clear_entropy=clear[:, 0],
        tau_c=detector.profile.tau_c,
    )


def proximity_range(renderings: Sequence[ApproachCurve], *, seed: int) -> Measured:
    """Distance from which on an approaching object is noticed for good, in half of the frames; mean over renderings."""
    draws, clear = renderings[0].entropy.shape[1], len(renderings[0].clear_entropy)
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, clear])))

    def drawn(curve: ApproachCurve, numbers: Index) -> float:
        return noticed_from(curve.gaps_mm, curve.rates(numbers, random.integers(0, clear, clear)))

    ranges = [noticed_from(curve.gaps_mm, curve.rates()) for curve in renderings]
    value, largest = float(np.mean(ranges)), renderings[0].gaps_mm[0]
    low, high = interval([partial(drawn, curve) for curve in renderings], draws, seed=seed)
    if max(ranges) >= largest:
        return Measured(value=value, low=low, high=None, note="at least: noticed at the largest distance tried")
    note = "not noticed at any distance tried" if value == 0 else ""
    return Measured(value=value, low=low, high=high, note=note)


def noticed_from(gaps_mm: Array, rates: Array) -> float:
    """Largest gap from which on inwards the rate stays at one half or more, between gaps by their logarithm [mm].

    Gaps fall, shape (gaps,). 0 where the rate is below one half at the smallest gap.
    """
    missed = np.flatnonzero(rates < DETECTED)
    if not len(missed):
        return float(gaps_mm[0])
    last = int(missed[-1])
    if last == len(gaps_mm) - 1:
        return 0.0
    share = (DETECTED - rates[last]) / (rates[last + 1] - rates[last])
    return float(np.exp(np.log(gaps_mm[last]) + share * np.log(gaps_mm[last + 1] / gaps_mm[last])))
