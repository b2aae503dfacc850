"""Frames of a video with the times that its container gives them; needs PyAV, the extra `video`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.detectors.frame import Frame
from magicsim.detectors.sources.image_header import check_pixels
from magicsim.errors import ConfigError, FrameError


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
