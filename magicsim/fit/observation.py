"""Frames of a real sensor in one state, averaged."""

import logging
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera
from magicsim.dataset.frames import open_frames
from magicsim.dataset.manifest import MANIFEST
from magicsim.detectors.frame import Frame
from magicsim.detectors.offline import said_of, told_of_references
from magicsim.detectors.source import read_source, source_kind
from magicsim.errors import ConfigError, FrameError, unknown_choice

_LOG = logging.getLogger(__name__)
MOST_FRAMES = 60
"""Frames that are read at most; more would not lower the noise that matters."""
SATURATED, MOST_SATURATED = 255, 0.01
"""A pixel at this grey level has lost its light; more than this share of them cannot be fitted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """Mean frames of one state, of the even and of the odd ones so that their noise is independent."""

    frame: int | None
    """Scored frame of the scene that they show, None for the untouched sensor."""
    even: Array
    """Grey levels, shape (rows, columns, 3)."""
    odd: Array
    """Grey levels of the odd frames, of that shape; `even` where there is a single frame."""
    count: int

    @property
    def mean(self) -> Array:
        """Grey levels of both together, shape (rows, columns, 3)."""
        return (self.even + self.odd) / 2


def observe(
    frames: Sequence[Frame], camera: Camera, *, frame: int | None = None, source: str = "frames"
) -> Observation:
    """Averages frames; `FrameError` where one has another size, or too many saturated pixels."""
    shape = (camera.window.rows, camera.window.columns, 3)
    for each in frames:
        if each.shape != shape:
            size = f"{each.shape[0]} rows and {each.shape[1]} columns, the rig's camera {shape[0]} and {shape[1]}"
            raise FrameError(f"{source}: an image has {size}; set rig.camera.rows and rig.camera.columns")
    for odd in told_of_references(frames, said_of(frames) if frame is None else []):
        _LOG.warning("%s: %s", source, odd)
    stack = np.asarray(frames, np.float64)
    lost = float((stack >= SATURATED).mean())
    if lost > MOST_SATURATED:
        most = f"at most {100 * MOST_SATURATED:g} % are allowed"
        raise FrameError(f"{source}: {100 * lost:.1f} % of the pixels are saturated; {most}")
    even = stack[::2].mean(0)
    return Observation(frame=frame, even=even, odd=stack[1::2].mean(0) if len(stack) > 1 else even, count=len(stack))


def read_observation(source: str | Path, camera: Camera, *, frame: int | None = None) -> Observation:
    """Frames of a file, folder, video or dataset; `ConfigError` where there are none, or of a camera."""
    folder, separator, episode = str(source).rpartition(":")
    if separator and (Path(folder) / MANIFEST).is_file():
        return observe(_images(Path(folder), episode), camera, frame=frame, source=str(source))
    if (Path(source) / MANIFEST).is_file():
        if frame is not None:
            msg = f"frame {frame}: '{source}' is a dataset; name an episode that shows one state, as in {source}:0"
            raise ConfigError(msg)
        return observe(_images(Path(source), None), camera, source=str(source))
    if source_kind(source) == "camera":
        raise ConfigError(f"source '{source}' is a camera; give recorded images, so that the fit can be repeated")
    with closing(read_source(source)) as reading:
        images = [each.image for each in islice(reading, MOST_FRAMES)]
    return observe(images, camera, frame=frame, source=str(source))


def _images(folder: Path, episode: str | None) -> list[Frame]:
    """Scored frames of a dataset's episode; for None the reference frames of all."""
    frames = open_frames(folder, ("image", "is_reference", "episode"))
    numbers, chosen = frames.column("episode"), frames.column("is_reference")
    if episode is not None:
        if not episode.isdecimal() or int(episode) not in numbers:
            raise ConfigError(unknown_choice(f"episode of '{folder}'", episode, map(str, np.unique(numbers).tolist())))
        chosen = (numbers == int(episode)) & ~chosen
    elif not chosen.any():
        raise ConfigError(f"dataset '{folder}' has no reference frames: name frames of the untouched sensor")
    found = frames.where(chosen)
    return [found[number]["image"] for number in range(min(len(found), MOST_FRAMES))]
