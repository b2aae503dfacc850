"""Recorded frames as magicsim reads them: order of colours, part, orientation, size, and the clock of a video."""

from importlib import import_module
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from magicsim.dataset.real.description import FrameForm
from magicsim.detectors.frame import Frame
from magicsim.detectors.orientation import Pixels, turned
from magicsim.errors import ConfigError, FrameError


def formed(frame: Frame, form: FrameForm, *, name: str = "frame") -> Frame:
    """A frame as a description asks for, by its name in a `FrameError` where the part to keep is not inside."""
    pixels: Pixels = frame[..., ::-1] if form.color_order == "bgr" else frame
    if form.crop_px is not None:
        column, row, columns, rows = form.crop_px
        if column + columns > pixels.shape[1] or row + rows > pixels.shape[0]:
            raise FrameError(
                f"frames.crop_px = {list(form.crop_px)} is not allowed: must lie inside of '{name}', which has "
                f"{pixels.shape[1]} x {pixels.shape[0]} pixels"
            )
        pixels = pixels[row : row + rows, column : column + columns]
    pixels = turned(pixels, (form.rotate_deg, form.mirror))
    if form.size_px is not None and form.size_px != (pixels.shape[1], pixels.shape[0]):
        is_smaller = form.size_px[0] * form.size_px[1] < pixels.shape[0] * pixels.shape[1]
        pixels = cv2.resize(
            np.ascontiguousarray(pixels), form.size_px, interpolation=cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
        )
    return np.ascontiguousarray(pixels, np.uint8)


def brightened(frame: Frame, gain: float) -> Frame:
    """A frame with its grey levels times a factor, rounded and cut off at white."""
    if gain == 1:
        return frame
    return np.asarray(np.clip(np.rint(frame.astype(np.float32) * gain), 0, 255), np.uint8)


def clock_start_s(path: Path) -> float:
    """When the clock of a video stands at its first frame, which need not be 0 [s]; needs PyAV (`ConfigError`)."""
    try:
        av: Any = import_module("av")
    except ModuleNotFoundError:
        raise ConfigError("a video with time stamps needs PyAV: pip install 'magicsim[video]'") from None
    av.logging.set_level(av.logging.PANIC)
    try:
        with av.open(str(path)) as container:
            stream = container.streams.best("video")
            start = stream.start_time if stream is not None else None
            return float(start * stream.time_base) if start is not None else 0.0
    except (av.error.FFmpegError, OSError) as error:
        raise FrameError(f"video '{path}' cannot be decoded: {getattr(error, 'strerror', None) or error}") from None
