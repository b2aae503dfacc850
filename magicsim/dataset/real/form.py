"""Recorded frames as magicsim reads them: order of colours, part, orientation, size, and the times of a video."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.dataset.real.description import FrameForm
from magicsim.detectors.frame import Frame, check_pixels
from magicsim.errors import ConfigError, FrameError

Pixels = npt.NDArray[Any]
Turn = tuple[int, bool]
"""Counter-clockwise turn [degrees], and whether left and right are exchanged after it."""
TURNS: tuple[Turn, ...] = tuple(product((0, 90, 180, 270), (False, True)))
"""Every orientation of a rectangle; the first changes nothing."""


def formed(frame: Frame, form: FrameForm, *, name: str = "frame") -> Frame:
    """A frame in the form that a description asks for.

    Args:
        frame: RGB, shape (rows, columns, 3).
        form: What to do.
        name: What a message calls the frame.

    Raises:
        FrameError: The part to keep is not inside the frame.
    """
    pixels: Pixels = frame[..., ::-1] if form.color_order == "bgr" else frame
    if form.crop_px is not None:
        column, row, columns, rows = form.crop_px
        if column + columns > pixels.shape[1] or row + rows > pixels.shape[0]:
            msg = (
                f"frames.crop_px = {list(form.crop_px)} is not allowed: must lie inside of '{name}', which has "
                f"{pixels.shape[1]} x {pixels.shape[0]} pixels"
            )
            raise FrameError(msg)
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


def turned(image: Pixels, turn: Turn) -> Pixels:
    """An image of shape (rows, columns, ...) turned and, after that, mirrored."""
    pixels = np.rot90(image, turn[0] // 90)
    return pixels[:, ::-1] if turn[1] else pixels


def after(first: Turn, then: Turn) -> Turn:
    """The one turn that does what two do one after the other."""
    mark = np.arange(6).reshape(2, 3)
    wanted = turned(turned(mark, first), then)
    return next(each for each in TURNS if np.array_equal(turned(mark, each), wanted))


def timed_frames(path: Path) -> Iterator[tuple[float, Frame]]:
    """Time from the first frame [s] and RGB image, shape (rows, columns, 3), in order of time.

    Raises:
        ConfigError: PyAV is missing.
        FrameError: The file is no video, or a frame has no time.
    """
    av = _pyav()
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                msg = f"video '{path}' holds no picture stream"
                raise FrameError(msg)
            stream = container.streams.video[0]
            check_pixels(f"video '{path}'", stream.codec_context.width, stream.codec_context.height)
            first = None
            for number, each in enumerate(container.decode(stream)):
                if each.time is None:
                    msg = f"video '{path}': frame {number} has no time; write it with time stamps, or save its images"
                    raise FrameError(msg)
                first = each.time if first is None else first
                yield float(each.time - first), np.asarray(each.to_ndarray(format="rgb24"), np.uint8)
            if first is None:
                msg = f"video '{path}' holds no frame that can be decoded"
                raise FrameError(msg)
    except (av.error.FFmpegError, OSError) as error:
        msg = f"video '{path}' cannot be decoded: {getattr(error, 'strerror', None) or error}"
        raise FrameError(msg) from None


def _pyav() -> Any:  # noqa: ANN401 - PyAV is optional
    try:
        import av
    except ModuleNotFoundError:
        msg = "a video with time stamps needs PyAV: pip install 'magicsim[video]'"
        raise ConfigError(msg) from None
    av.logging.set_level(av.logging.PANIC)
    return av
