"""A detector of its own for every design: thresholds fitted on some of the film, judged on the rest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.detectors.calibrate import Candidates, fit_profile
from magicsim.detectors.combined import detect_all
from magicsim.detectors.features import Episode
from magicsim.detectors.frame import Frame
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import NEAR_MAX_MM, FrameClass
from magicsim.sweep.judging.filmed_design import Film, Shown

TRAINING_DRAWS = 2
"""Frames of each state that the fit sees."""
CLEAR_DRAWS = 12
"""Frames of the untouched sensor that it sees."""
FULL_ROWS = 320
"""Rows of the image that the published kernels are for."""
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


def fit_detector(film: Film) -> FittedDetector:
    """Fits thresholds and options to the training part of a film.

    `published` gives what is not fitted, its kernel as large on the face as in a whole image.

    Raises:
        ConfigError: No option leaves a grid to be seen.
    """
    start = load_profile("published")
    size = kernel_px(start.grid_blur_px, film.camera.rows)
    kernels = sorted({0, kernel_px(5, film.camera.rows), kernel_px(9, film.camera.rows)})
    candidates = Candidates(grid_blur_px=(size,), difference_blur_px=kernels)
    references = film.references()
    profile = fit_profile(start, [training_episode(film, references)], candidates).profile
    return FittedDetector(profile=profile, references=fuse(references, profile))


def training_episode(film: Film, references: Sequence[Frame]) -> Episode:
    """Labelled frames of every class: every second place, and states on the axis."""
    clear = film.frames(film.untouched, CLEAR_DRAWS)
    groups: list[tuple[FrameClass, Sequence[Shown]]] = [
        (FrameClass.NEAR, [*film.near[TRAINING::2], *(each for each in film.approach if is_near(each))]),
        (FrameClass.CONTACT, [*film.light_touches[TRAINING::2], *film.touches[TRAINING::2]]),
        (FrameClass.LIGHT, film.light[TRAINING::2]),
    ]
    frames, classes = list(clear), [FrameClass.CLEAR] * len(clear)
    for kind, states in groups:
        for shown in states:
            frames += film.frames(shown, TRAINING_DRAWS)
            classes += [kind] * TRAINING_DRAWS
    return Episode(references=references, frames=frames, classes=classes)


def is_near(shown: Shown) -> bool:
    """Whether a state counts as near."""
    return shown.gap_mm is not None and 0 < shown.gap_mm <= NEAR_MAX_MM


def fixed_detector(film: Film) -> FittedDetector:
    """A detector with one set of options for every design, so that their similarities can be compared.

    Bright pixels are the grid from the mean grey level upwards, and the overlap is intersection over union: half of the
    pixels lie on each side of the threshold, and whatever moves or changes brightness shows.
    """
    profile = replace(
        load_profile("published"),
        tau_b=round(film.camera.exposure_grey),
        polarity="bright",
        similarity="iou",
        grid_blur_px=kernel_px(5, film.camera.rows),
    )
    return FittedDetector(profile=profile, references=fuse(film.references(), profile))


def kernel_px(full_px: int, rows: int) -> int:
    """An odd kernel for a smaller image that covers about as much of the face [px]; 0 where that is no pixel."""
    size = 2 * round((full_px * rows / FULL_ROWS - 1) / 2) + 1
    return size if size > 1 else 0
