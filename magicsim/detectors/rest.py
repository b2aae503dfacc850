"""E, C and S in units of the untouched sensor at hand, for profiles with `units = "rest"`.

One number for all sensors fails: noise, room and exposure give each its own E, C and S at rest. So every frame is first
reduced to one size and brought to the brightness that the sensor has at rest, which takes exposure, its steps and
drift out of it. Then the published algorithms run as they are, and their three numbers are told from rest:

- S as a share of S at rest. The grid is the darker `tau_b` per cent of each channel's untouched pixels, so that
  neither exposure nor tone curve moves it, and a frame is darkened by `MARGIN` before its grid is told, so that a pixel
  leaves the grid by a brightening which neither noise nor the light of something near makes.
- E in bits above rest.
- C as a share of the way from the likeness of the channels in the untouched picture to full likeness: under white light
  all changes are alike, and C says nothing of where light comes from.

S and E at rest are measured as the frames to come are: reference frames in thirds, each against the two others. What
rest itself does, `REPEATABILITY_SD` standard deviations of it, never reaches a threshold. Levels at rest follow slowly.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from typing import Self

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.features import (
    brightening,
    brightening_correlation,
    filter_channels,
    grid_areas,
    grid_similarity,
)
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import BackgroundReference, GridReference, blur, fuse_background, fuse_grid
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import REPEATABILITY_SD, Contact, Proximity, Verdict
from magicsim.errors import ConfigError, FrameError

Levels = npt.NDArray[np.float32]
LONGEST_PX = 160
"""Longer side of the frames that are judged [px]; larger ones are reduced, which takes noise out too."""
GRID_LEVEL = 127
"""Grey level to which the share `tau_b` of the untouched pixels is brought before the grid is told from it."""
MARGIN = 0.2
"""Share of its brightness that a frame loses before its grid is told; references lose nothing."""
LIKENESS_FLOOR = 0.02
"""Added to what is left between the untouched picture's likeness and 1: less than that, and C says nothing."""
FOLLOWED_FRAMES, NEAR_FRAMES = 300, 3000
"""Frames in which levels at rest follow a change to 1/e: when nothing is near, and when something is."""
TOUCH_SHARE = 0.3
"""Share of the fall of S in the sensor's own touches from which a frame is touched."""
READABLE = (8, 245)
"""Grey levels between which a pixel tells the brightness."""
LEAST_PIXELS = 0.01
"""Share of the pixels that must be readable for a channel's brightness to be told."""
THIRDS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """The untouched sensor in its own units, from `fuse` with a profile in units of rest."""

    shape: tuple[int, ...]
    """Shape of the frames before they are reduced."""
    mean: Levels
    """Mean of the reference frames, reduced, shape (rows, columns, 3) [grey levels]."""
    grid_gain: tuple[float, ...]
    """What brings each channel's share `tau_b` to `GRID_LEVEL`."""
    likeness: float
    """Correlation of the channels of the mean, not below 0."""
    entropy: float = 0.0
    entropy_sd: float = 0.0
    similarity: float = 1.0
    similarity_sd: float = 0.0
    touch: float | None = None
    """S in the sensor's own first touches; None where none were shown."""

    @classmethod
    def of(cls, frames: Sequence[Frame], profile: DetectorProfile) -> Self:
        """What is known before anything is measured; frames have one shape, (rows, columns, 3)."""
        mean: Levels = np.stack([reduced(each) for each in frames]).mean(axis=0, dtype=np.float32)
        smooth = blur(_rounded(mean), profile.grid_blur_px, profile.grid_blur_sigma_px)
        edges = np.percentile(smooth, profile.tau_b, axis=(0, 1))
        likeness = brightening_correlation(_rounded(mean))
        gain = tuple((GRID_LEVEL + 0.5) / (each + 0.5) for each in edges.tolist())
        return cls(shape=frames[0].shape, mean=mean, grid_gain=gain, likeness=max(0.0, likeness))

    def matched(self, frame: Frame) -> Levels:
        """A frame reduced, each channel as bright as at rest.

        By the median over its pixels, which a touch of less than half of the picture does not move.
        """
        image = np.asarray(reduced(frame), dtype=np.float32)
        low, high = READABLE
        for channel in range(image.shape[2]):
            now, rest = image[..., channel], self.mean[..., channel]
            told = (rest > low) & (rest < high) & (now < high)
            if np.count_nonzero(told) > LEAST_PIXELS * told.size:
                image[..., channel] /= max(float(np.median(now[told] / rest[told])), 1 / high)
        return image

    def features(
        self, matched: Levels, references: "References", profile: DetectorProfile
    ) -> tuple[float, float, float]:
        """E, C and S of the published algorithms for a matched frame."""
        filtered = filter_channels(_rounded(matched), references.background)
        areas = grid_areas(self.for_grid(matched * np.float32(1 - MARGIN)), references.grid)
        return (*brightening(filtered, profile), grid_similarity(areas, profile.similarity))

    def for_grid(self, matched: Levels) -> Frame:
        """A matched frame with the share `tau_b` of its untouched pixels at or below `GRID_LEVEL`."""
        return _rounded(matched * np.array(self.grid_gain, np.float32))

    def relative(self, features: tuple[float, float, float], profile: DetectorProfile) -> tuple[float, float, float]:
        """E [bit above rest], C and S in units of rest."""
        entropy, correlation, similarity = features
        bits, share = self._scales(profile)
        return (
            (entropy - self.entropy) * bits,
            max(-1.0, (correlation - self.likeness) / (1 - self.likeness + LIKENESS_FLOOR)),
            1 - (1 - similarity / self.similarity) * share,
        )

    def followed(self, verdict: Verdict, profile: DetectorProfile) -> Self:
        """Levels moved towards those of an untouched frame: faster where nothing is near."""
        if verdict.contact is Contact.TOUCHED or verdict.proximity is Proximity.NOISE:
            return self
        frames = FOLLOWED_FRAMES if verdict.proximity is Proximity.NORMAL else NEAR_FRAMES
        bits, share = self._scales(profile)
        return replace(
            self,
            entropy=self.entropy + verdict.entropy / bits / frames,
            similarity=self.similarity * (1 - (1 - verdict.similarity) / share / frames),
        )

    def _scales(self, profile: DetectorProfile) -> tuple[float, float]:
        """What E and the fall of S are multiplied by.

        Thresholds stay `REPEATABILITY_SD` from rest, and that of S lies at `TOUCH_SHARE` of the fall in the sensor's
        own touches where these are known.
        """
        fall = 1 - profile.tau_g
        wanted = fall if self.touch is None else TOUCH_SHARE * (1 - self.touch / self.similarity)
        least = REPEATABILITY_SD * self.similarity_sd / self.similarity
        bits = min(1.0, profile.tau_e / max(1e-9, REPEATABILITY_SD * self.entropy_sd))
        return max(bits, 1e-9), fall / max(wanted, least, 1e-9)


@dataclass(frozen=True, slots=True, kw_only=True)
class References:
    """All that the detectors remember of the untouched sensor."""

    background: BackgroundReference
    grid: GridReference
    rest: Rest | None = None
    """The sensor's own units; None with fixed thresholds."""


def fuse(frames: Iterable[Frame], profile: DetectorProfile) -> References:
    """Build the references from frames of the untouched sensor, in their order in time.

    Takes the first `profile.reference_count` frames. Fewer are accepted as long as each background
    reference gets a frame; `References.grid.frames` tells how many there were.

    Raises:
        FrameError: Fewer frames than background references, a frame that is not an image, frames of
            different sizes, or no grid in any channel.
    """
    taken = list(islice(frames, profile.reference_count))
    if len(taken) < profile.background_count:
        raise FrameError(
            f"{len(taken)} reference frame(s) are too few; must be at least background_count = "
            f"{profile.background_count}, better reference_count = {profile.reference_count}"
        )
    first = check_frame(taken[0])
    checked = [check_frame(frame, shape=first.shape) for frame in taken]
    if profile.units == "rest":
        return _rest_references(checked, profile)
    return References(
        background=fuse_background(checked, count=profile.background_count, blur_px=profile.difference_blur_px),
        grid=fuse_grid(checked, profile),
    )


def _rest_references(frames: Sequence[Frame], profile: DetectorProfile) -> References:
    """References in units of rest from at least three frames of the untouched sensor (`FrameError`), see `fuse`."""
    if len(frames) < THIRDS:
        raise FrameError(f"{len(frames)} reference frame(s) are too few for units = 'rest'; must be at least {THIRDS}")
    rest = Rest.of(frames, profile)
    matched = [rest.matched(each) for each in frames]
    edges = [number * len(frames) // THIRDS for number in range(THIRDS + 1)]
    found = []
    for start, stop in pairwise(edges):
        others = _references([*matched[:start], *matched[stop:]], rest, profile)
        found += [rest.features(each, others, profile) for each in matched[start:stop]]
    (entropy, _, similarity), (entropy_sd, _, similarity_sd) = np.mean(found, 0), np.std(found, 0, ddof=1)
    known = replace(
        rest, entropy=float(entropy), entropy_sd=float(entropy_sd), similarity=max(float(similarity), 1e-9),
        similarity_sd=float(similarity_sd),
    )  # fmt: skip
    return _references(matched, known, profile)


def _references(matched: Sequence[Levels], rest: Rest, profile: DetectorProfile) -> References:
    grid = fuse_grid([rest.for_grid(each) for each in matched], replace(profile, units="fixed", tau_b=GRID_LEVEL))
    count = min(profile.background_count, len(matched))
    background = fuse_background([_rounded(each) for each in matched], count=count, blur_px=profile.difference_blur_px)
    return References(background=background, grid=grid, rest=rest)


def with_touches(references: References, touches: Sequence[Frame], profile: DetectorProfile) -> References:
    """References that know the sensor's own first touches.

    S there sets the threshold, and where these touches are as alike in all channels as outside light is, C decides
    nothing.

    Args:
        references: From `fuse` with the same profile.
        touches: Frames of the touched sensor, one to three touches, each (rows, columns, 3); none in between.
        profile: In units of rest.

    Raises:
        ConfigError: The profile has fixed thresholds, there is no frame, or S does not fall in the touches.
        FrameError: A frame cannot be used.
    """
    rest = references.rest
    if rest is None:
        raise ConfigError("touches are not allowed with fixed thresholds; name a profile with units = 'rest'")
    if not touches:
        raise ConfigError("touches hold no frame; must be frames of the touched sensor, of one to three touches")
    found = [rest.features(rest.matched(check_frame(each, shape=rest.shape)), references, profile) for each in touches]
    _, correlation, similarity = np.median(found, axis=0).tolist()
    fall = max(TOUCH_SHARE * (1 - profile.tau_g) * rest.similarity, REPEATABILITY_SD * rest.similarity_sd / TOUCH_SHARE)
    if similarity >= (most := rest.similarity - fall):
        raise ConfigError(
            f"touches do not lower S: {similarity:.4f} beside {rest.similarity:.4f} at rest; must be below {most:.4f} "
            "in frames of firm touches alone"
        )
    is_alike = rest.relative((0.0, correlation, 1.0), profile)[1] >= profile.tau_c
    return replace(references, rest=replace(rest, touch=similarity, likeness=1.0 if is_alike else rest.likeness))


def reduced(frame: Frame) -> Frame:
    """A frame of at most `LONGEST_PX` on its longer side, by means over areas."""
    rows, columns = frame.shape[:2]
    scale = LONGEST_PX / max(rows, columns)
    if scale >= 1:
        return frame
    size = (max(1, round(columns * scale)), max(1, round(rows * scale)))
    return np.asarray(cv2.resize(frame, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _rounded(levels: Levels) -> Frame:
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)
