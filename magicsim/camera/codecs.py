"""Frames as compression leaves them: JPEG one by one, H.264 as a stream, which needs PyAV, the extra `video`."""

from fractions import Fraction
from typing import Any

import cv2
import numpy as np

from magicsim.arrays import Frame
from magicsim.camera.effect_settings import H264, Mjpeg
from magicsim.errors import ConfigError

SAMPLING = {
    "444": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "422": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "420": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}
LOW_DELAY = 0x80000
"""FFmpeg's flag of a decoder that gives each frame at once."""


class VideoCodec:
    """Coder and decoder of one stream, each in one thread: the same frames give the same bytes."""

    def __init__(self, h264: H264, *, rows: int, columns: int, frames_per_second: float) -> None:
        """Opens both.

        Raises:
            ConfigError: PyAV is missing.
        """
        av = _pyav()
        coder = av.CodecContext.create("libx264", "w")
        coder.width, coder.height, coder.pix_fmt = columns, rows, "yuv420p"
        coder.time_base = 1 / Fraction(frames_per_second).limit_denominator(1000)
        coder.gop_size, coder.thread_count = h264.keyframe_frames, 1
        coder.options = {"crf": str(h264.crf), "preset": "veryfast", "tune": "zerolatency", "threads": "1"}
        decoder = av.CodecContext.create("h264", "r")
        decoder.thread_count = 1
        decoder.flags |= LOW_DELAY
        self._video_frame, self._coder, self._decoder, self._count = av.VideoFrame, coder, decoder, 0

    def through(self, frame: Frame) -> Frame:
        """The next frame of the stream, compressed and decompressed; RGB, shape (rows, columns, 3)."""
        picture = self._video_frame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
        picture.pts, self._count = self._count, self._count + 1
        found = [each for packet in self._coder.encode(picture) for each in self._decoder.decode(packet)]
        return np.asarray(found[-1].to_ndarray(format="rgb24"), np.uint8)


def check_codec(compression: H264 | Mjpeg | None) -> None:
    """Refuses a video that cannot be coded here, before anything is rendered for it.

    Raises:
        ConfigError: PyAV is missing.
    """
    if isinstance(compression, H264):
        _pyav()


def _pyav() -> Any:  # noqa: ANN401 - PyAV is optional
    try:
        import av
    except ModuleNotFoundError:
        raise ConfigError("camera.compression.kind = 'h264' needs PyAV; `pip install magicsim[video]`") from None
    return av


def through_mjpeg(frame: Frame, mjpeg: Mjpeg) -> Frame:
    """The frame compressed and decompressed.

    Args:
        frame: RGB, shape (rows, columns, 3).
        mjpeg: Quality and sampling of the colours.
    """
    options = [cv2.IMWRITE_JPEG_QUALITY, mjpeg.quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, SAMPLING[mjpeg.chroma]]
    packed = cv2.imencode(".jpg", np.ascontiguousarray(frame[..., ::-1]), options)[1]
    unpacked = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
    return np.ascontiguousarray(unpacked[..., ::-1])
