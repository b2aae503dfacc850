"""Labelled frames of one untouched sensor, and their features for many options at once."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.detectors.contact import grid_similarity, mask_areas
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import blur, fuse_background, fuse_grid, levelled
from magicsim.detectors.profile import DetectorProfile, Polarity, Similarity
from magicsim.detectors.proximity import brightening_correlation, brightening_entropy, filter_channels
from magicsim.errors import ConfigError, FrameError
from magicsim.frame_class import FrameClass

Features = npt.NDArray[np.float64]
"""One feature of every scored frame, shape (frames,)."""
GridOption = tuple[int, Polarity, int, int]
"""tau_b, polarity, grid blur [px] and surroundings [px]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """Frames that share one set of references."""

    references: Sequence[Frame]
    """Frames of the untouched sensor in their order, each (rows, columns, 3)."""
    frames: Sequence[Frame]
    """Frames to judge, each (rows, columns, 3)."""
    classes: Sequence[FrameClass | None]
    """True class of each frame; None leaves it out."""

    def __post_init__(self) -> None:
        """Refuse classes that do not match the frames."""
        if len(self.frames) != len(self.classes):
            msg = f"episode has {len(self.frames)} frames and {len(self.classes)} classes; must be one for each"
            raise ConfigError(msg)


def scored_classes(episodes: Iterable[Episode]) -> list[FrameClass]:
    """Classes of the scored frames of all episodes, in order."""
    return [each for episode in episodes for each in episode.classes if each is not None]


def measure_brightening(
    episodes: Iterable[Episode], base: DetectorProfile, difference_blur_px: int
) -> tuple[Features, Features]:
    """Entropy E [bit] and correlation C of the scored frames, each of shape (frames,).

    The base gives the numbers of references and of reference frames, and the options of entropy and correlation.

    Raises:
        FrameError: A frame is not an image of its episode's size, or an episode has too few references.
    """
    entropies, correlations = [], []
    for episode in episodes:
        references = _checked_references(episode, base)
        background = fuse_background(references, count=base.background_count, blur_px=difference_blur_px)
        for frame in _scored_frames(episode, references[0].shape):
            filtered = filter_channels(frame, background)
            entropies.append(
                brightening_entropy(filtered, bins=base.entropy_bins, grey=base.grey, rounding=base.grey_rounding)
            )
            correlations.append(brightening_correlation(filtered, constant=base.constant_channel))
    return np.array(entropies), np.array(correlations)


def measure_similarity(
    episodes: Iterable[Episode],
    base: DetectorProfile,
    options: Sequence[GridOption],
    similarities: Sequence[Similarity],
) -> Mapping[tuple[GridOption, Similarity], Features | None]:
    """Grid similarity S of the scored frames for every option and measure, each of shape (frames,).

    A frame is blurred and levelled once for each pair of kernels and binarised once for each option, whatever the
    measures. S is None for an option under which the references of an episode show no grid.
    """
    values: dict[tuple[GridOption, Similarity], list[float]] = {
        (option, similarity): [] for option in options for similarity in similarities
    }
    empty: set[GridOption] = set()
    for episode in episodes:
        references = _checked_references(episode, base)
        frames = _scored_frames(episode, references[0].shape)
        for size, surround_px in sorted({option[2:] for option in options}):
            level = [levelled(blur(frame, size, base.grid_blur_sigma_px), surround_px) for frame in frames]
            for option in options:
                if option[2:] != (size, surround_px) or option in empty:
                    continue
                tau_b, polarity = option[:2]
                try:
                    grid = fuse_grid(
                        references, tau_b=tau_b, polarity=polarity, blur_px=size, surround_px=surround_px,
                        blur_sigma_px=base.grid_blur_sigma_px, kind=base.grid_reference,
                    )  # fmt: skip
                except FrameError:
                    empty.add(option)
                    continue
                areas = [mask_areas(image, grid) for image in level]
                for similarity in similarities:
                    values[option, similarity] += [grid_similarity(each, similarity) for each in areas]
    return {key: None if key[0] in empty else np.array(each) for key, each in values.items()}


def _checked_references(episode: Episode, base: DetectorProfile) -> list[Frame]:
    """The reference frames that `fuse` would take."""
    taken = episode.references[: base.reference_count]
    if len(taken) < base.background_count:
        raise FrameError(f"episode has {len(taken)} reference frame(s); must be at least {base.background_count}")
    first = check_frame(taken[0])
    return [check_frame(frame, shape=first.shape) for frame in taken]


def _scored_frames(episode: Episode, shape: tuple[int, ...]) -> list[Frame]:
    """The frames that have a class, checked."""
    pairs = zip(episode.frames, episode.classes, strict=True)
    return [check_frame(frame, shape=shape) for frame, each in pairs if each is not None]
