"""Frames of a real sensor in one state, averaged."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.detectors.sources.source import read_source, source_kind
from magicsim.errors import ConfigError, FrameError
from magicsim.scenes.rig import Camera

Array = npt.NDArray[np.float64]
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
    """Averages frames.

    Args:
        frames: RGB, of the camera's size, at least one.
        camera: Of the rig that is fitted.
        frame: Which scored frame of the scene they show.
        source: Where they came from, for messages.

    Raises:
        FrameError: Another size, or too many saturated pixels.
    """
    shape = (camera.window.rows, camera.window.columns, 3)
    for each in frames:
        if each.shape != shape:
            msg = (
                f"{source}: an image has {each.shape[0]} rows and {each.shape[1]} columns, the rig's camera "
                f"{shape[0]} and {shape[1]}; set rig.camera.rows and rig.camera.columns"
            )
            raise FrameError(msg)
    stack = np.asarray(frames, np.float64)
    lost = float((stack >= SATURATED).mean())
    if lost > MOST_SATURATED:
        msg = (
            f"{source}: {100 * lost:.1f} % of the pixels are saturated; at most {100 * MOST_SATURATED:g} % are allowed"
        )
        raise FrameError(msg)
    even = stack[::2].mean(0)
    return Observation(frame=frame, even=even, odd=stack[1::2].mean(0) if len(stack) > 1 else even, count=len(stack))


def read_observation(source: str | Path, camera: Camera, *, frame: int | None = None) -> Observation:
    """Frames of a file, a folder or a video.

    Raises:
        ConfigError: No such source, or a camera, which cannot be read again.
        FrameError: An image cannot be used.
    """
    if source_kind(source) == "camera":
        msg = f"source '{source}' is a camera; give recorded images, so that the fit can be repeated"
        raise ConfigError(msg)
    images = []
    reading = read_source(source)
    for each in reading:
        images.append(each.image)
        if len(images) == MOST_FRAMES:
            break
    reading.close()
    return observe(images, camera, frame=frame, source=str(source))
