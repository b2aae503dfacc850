"""Frames of a video file or a camera, through OpenCV.

Lossy codecs move grey levels by more than the thresholds allow for: record with a lossless one (FFV1), or take the
references from the same recording.
"""

import logging
import os
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from magicsim.detectors.frame import Frame, check_pixels
from magicsim.errors import FrameError

VIDEO_SUFFIXES = (".avi", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".webm")
"""File name endings that are read as videos, in any case."""
_LOG = logging.getLogger(__name__)


def open_video(path: Path) -> Generator[Frame, None, None]:
    """Frames of a video file as RGB, one at a time; warns at the end where the file promised more.

    Raises:
        FrameError: The file cannot be opened, has frames that are too large, or holds none that can be decoded; raised
            at once.
    """
    capture = _capture(str(path))
    if capture.isOpened():
        columns, rows = (round(capture.get(each)) for each in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        try:
            check_pixels(f"video '{path}'", columns, rows)
        except FrameError:
            capture.release()
            raise
    first = _next(capture) if capture.isOpened() else None
    if first is None:
        capture.release()
        raise FrameError(f"video '{path}' cannot be decoded; must be a whole video file in a format that OpenCV reads")
    return _video_frames(capture, first, path)


def read_camera(index: int) -> Generator[Frame, None, None]:
    """Frames of a camera as RGB, without end; opened with the first frame, released when closed.

    Raises:
        FrameError: There is no such camera, or it stops giving frames.
    """
    capture = _capture(index)
    try:
        if not capture.isOpened():
            msg = f"camera {index} cannot be opened; must be the index of a connected camera that nothing else uses"
            raise FrameError(msg)
        number = 0
        while (frame := _next(capture)) is not None:
            number += 1
            yield frame
        raise FrameError(f"camera {index} gave no more frames after {number}")
    finally:
        capture.release()


def _video_frames(capture: cv2.VideoCapture, first: Frame, path: Path) -> Generator[Frame, None, None]:
    promised = round(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    number = 0
    try:
        frame: Frame | None = first
        while frame is not None:
            number += 1
            yield frame
            frame = _next(capture)
        if number < promised:
            _LOG.warning("video '%s' gave %d of %d frames; the rest is damaged or missing", path.name, number, promised)
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


def _next(capture: cv2.VideoCapture) -> Frame | None:
    with quiet_opencv():
        good, frame = capture.read()
    return np.ascontiguousarray(frame[:, :, ::-1], dtype=np.uint8) if good else None


@contextmanager
def quiet_opencv() -> Iterator[None]:
    """OpenCV's own log is silent inside the block, and as before after it."""
    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(before)
