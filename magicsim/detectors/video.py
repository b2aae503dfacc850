"""Frames of a video file or a camera, through OpenCV.

Lossy codecs move grey levels by more than the thresholds allow for: record with a lossless one (FFV1), or take the
references from the same recording.
"""

import logging
import math
import os
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from magicsim.detectors.frame import Frame, check_pixels
from magicsim.errors import FrameError

VIDEO_SUFFIXES = (".avi", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".webm")
"""File name endings that are read as videos, in any case."""
LOSSLESS = ("FFV1", "FFVH", "HFYU", "UL", "UM", "UQ", "M8", "MAGY", "LAGS", "PNG", "MPNG", "RAW", "DIB", "BGR", "RGB",
            "RLE", "QRLE", "ZMBV", "CSCD", "FPS1", "I420", "YV12", "YUY2", "UYVY", "NV12", "Y800", "GREY")  # fmt: skip
"""How the names of codecs begin that keep what they are given."""
COARSE_COLOURS = ("I420", "YV12", "IYUV", "NV12", "NV21", "YUY2", "UYVY", "Y42B", "422P", "411P", "410P")
"""Layouts of pixels that have colours for every second pixel or fewer."""
COUNTING = (".avi", ".m4v", ".mov", ".mp4")
"""Endings of containers that hold the number of their frames; of others it is guessed from their duration."""
Remark = Callable[[str], None]
"""Takes one line about what was done to frames, or what is odd about them."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A frame whose image is not made yet."""

    name: str
    read: Callable[[], Frame]
    """Makes the RGB image, shape (rows, columns, 3); to be called before the next frame is asked for."""
    time_s: float = math.nan
    """From the first frame of a video, by its time stamps [s], 0 where it has none; NaN of images and cameras."""


Shots = Generator[Shot, None, None]
"""Frames that are not made yet, one at a time; closing it releases what it reads from."""


def open_video(path: Path, remark: Remark | None = None) -> Shots:
    """Frames of a video file, one at a time, upright as its track says.

    `remark` hears at once that frames are turned or that the codec loses detail, and at the end that the file promised
    more frames; the log by default. `FrameError`, at once, where the file cannot be opened, has frames that are too
    large, or holds none that can be decoded.
    """
    remark = remark or _LOG.warning
    capture = _capture(str(path))
    if capture.isOpened():
        columns, rows = (round(capture.get(each)) for each in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        try:
            check_pixels(f"video '{path}'", columns, rows)
        except FrameError:
            capture.release()
            raise
    if not capture.isOpened() or not _grab(capture):
        capture.release()
        raise FrameError(f"video '{path}' cannot be decoded; must be a whole video file in a format that OpenCV reads")
    turn = round(capture.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
    if turn:
        remark(
            f"video '{path.name}': frames are turned by {turn} degrees, as its track says; references and frames have "
            "to be turned alike"
        )
    if loss := _loss(capture):
        remark(
            f"video '{path.name}' {loss}: frames of something near may be judged Touched; record without loss (FFV1 "
            "of RGB, or PNG images)"
        )
    return _video_frames(capture, path, remark)


def _loss(capture: cv2.VideoCapture) -> str:
    """What a video's coding loses; nothing where it keeps every pixel or nobody knows."""
    codec, pixels = (
        _four_characters(capture.get(each)) for each in (cv2.CAP_PROP_FOURCC, cv2.CAP_PROP_CODEC_PIXEL_FORMAT)
    )
    if not codec.strip() or not codec.isprintable():
        return ""
    if not codec.upper().startswith(LOSSLESS):
        return f"is coded as {codec.strip()}, which loses detail unless it is told not to"
    return f"is coded as {codec.strip()} with colours of fewer pixels ({pixels})" if pixels in COARSE_COLOURS else ""


def _four_characters(code: float) -> str:
    return (int(code) & 0xFFFFFFFF).to_bytes(4, "little").decode("latin-1")


def read_camera(index: int) -> Generator[Frame, None, None]:
    """Frames of a camera as RGB, without end; opened with the first frame, released when closed.

    `FrameError` where there is no such camera, or it stops giving frames.
    """
    capture = _capture(index)
    try:
        if not capture.isOpened():
            msg = f"camera {index} cannot be opened; must be the index of a connected camera that nothing else uses"
            raise FrameError(msg)
        number = 0
        while True:
            with quiet_opencv():
                good, frame = capture.read()
            if not good:
                break
            number += 1
            yield _rgb(frame)
        raise FrameError(f"camera {index} gave no more frames after {number}")
    finally:
        capture.release()


def _video_frames(capture: cv2.VideoCapture, path: Path, remark: Remark) -> Shots:
    promised = round(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    number, reached, longest, is_there = 0, -1, 1, True
    try:
        while is_there:
            stamp = round(capture.get(cv2.CAP_PROP_PTS))
            longest, reached = max(longest, stamp - reached if number else 1), max(reached, stamp)
            time_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            read = partial(_retrieved, capture, path, number)
            yield Shot(name=f"{path.name}#{number}", read=read, time_s=time_s)
            number += 1
            is_there = _grab(capture)
        if number < promised and reached + longest < promised:
            remark(f"video '{path.name}' gave {number} of {promised} frames; the rest is damaged or missing")
        elif number < promised and path.suffix.lower() in COUNTING:
            remark(
                f"video '{path.name}' gave {number} of {promised} frames, up to its end: the others were dropped "
                "as it was taken, or cannot be read; the times of these are right"
            )
    finally:
        capture.release()


def _capture(source: str | int) -> cv2.VideoCapture:
    """Open a source without OpenCV and FFmpeg writing to standard error; what fails is reported once, by us."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # AV_LOG_QUIET, read when FFmpeg is first used
    os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", "fflags;discardcorrupt")  # no frame from half a packet
    with quiet_opencv():
        if isinstance(source, str) and cv2.CAP_FFMPEG in cv2.videoio_registry.getStreamBackends():
            return cv2.VideoCapture(source, cv2.CAP_FFMPEG)  # other readers write to standard error as they fail
        return cv2.VideoCapture(source)


def _grab(capture: cv2.VideoCapture) -> bool:
    with quiet_opencv():
        return bool(capture.grab())


def _retrieved(capture: cv2.VideoCapture, path: Path, number: int) -> Frame:
    with quiet_opencv():
        good, frame = capture.retrieve()
    if not good:
        raise FrameError(f"video '{path}': frame {number} cannot be decoded")
    return _rgb(frame)


def _rgb(frame: np.ndarray) -> Frame:
    return np.ascontiguousarray(frame[:, :, ::-1], dtype=np.uint8)


@contextmanager
def quiet_opencv() -> Iterator[None]:
    """OpenCV's own log is silent inside the block, and as before after it."""
    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(before)
