"""Animated preview of a stream: the frames, each above a strip that says what is true and what was said."""

import io
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from PIL import Image

from magicsim.detectors.verdict import Verdict
from magicsim.errors import OutputError
from magicsim.folder import result_file
from magicsim.report.animation.preview_strip import with_strip
from magicsim.simulation.episode import SimulatedFrame

PREVIEW_BYTES = 3_000_000
"""Size above which a preview is made with smaller pictures [bytes]."""

_SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)


def animate(
    frames: Sequence[SimulatedFrame],
    path: Path,
    frames_per_second: float,
    *,
    verdicts: Sequence[Verdict] | None = None,
    max_bytes: int = PREVIEW_BYTES,
) -> Path:
    """Write an animation that loops, as large as `max_bytes` allows, at least at a quarter of the size.

    Args:
        frames: What to show, at least one frame.
        path: File to write, WebP.
        frames_per_second: Frame rate [1/s].
        verdicts: One for each frame; left out or empty, the strip states the truth alone.
        max_bytes: Size to stay below [bytes].

    Returns:
        The path.

    Raises:
        OutputError: No frames, a frame rate of 0 or less, or another number of verdicts than of frames; or the file
            cannot be written.
    """
    if not frames or frames_per_second <= 0.0:
        msg = f"{len(frames)} frames at {frames_per_second:g}/s make no preview; both must be above 0"
        raise OutputError(msg)
    if verdicts and len(verdicts) != len(frames):
        msg = f"{len(verdicts)} verdicts for {len(frames)} frames; must be one for each"
        raise OutputError(msg)
    told: Sequence[Verdict | None] = verdicts or [None] * len(frames)
    data = b""
    for scale in _SCALES:
        pictures = [with_strip(frame, one, scale=scale) for frame, one in zip(frames, told, strict=True)]
        data = _encode(pictures, frames_per_second)
        if len(data) <= max_bytes:
            break
    with result_file(path) as partial:
        partial.write_bytes(data)
    return path


def _encode(pictures: Sequence[Image.Image], frames_per_second: float) -> bytes:
    buffer = io.BytesIO()
    pictures[0].save(
        buffer,
        format="WEBP",
        save_all=True,
        append_images=pictures[1:],
        duration=_durations_ms(len(pictures), frames_per_second),
        loop=0,
        quality=80,
        method=2,
    )
    return buffer.getvalue()


def _durations_ms(count: int, frames_per_second: float) -> list[int]:
    """Time that each frame stays [ms], rounded so that the errors do not add up."""
    ends = [round(1000.0 * k / frames_per_second) for k in range(count + 1)]
    return [max(1, later - earlier) for earlier, later in pairwise(ends)]
