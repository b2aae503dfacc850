"""Pictures of one episode: what the watched finger sees, with the machine's stage and its three numbers below."""

import io
from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from magicsim.arrays import Frame
from magicsim_experiments.task.episode import FrameRow

BAR_PX = 46
"""Height of the text below each image."""
COLUMNS, MOST = 8, 24
"""Images in a row of a contact sheet, and in all of it."""
SCALE = 0.35


def told(image: Frame, row: FrameRow) -> Frame:
    """An image with its line of text."""
    lines = (
        f"{row.time_s:5.2f} s  {row.stage}" + (f"  {row.event}" if row.event else ""),
        f"E {row.entropy:.1f}  C {row.correlation:.2f}  S {row.similarity:.2f}  {max(row.upper_n, row.lower_n):.1f} N",
    )
    bar = np.full((BAR_PX, image.shape[1], 3), 255, np.uint8)
    for number, line in enumerate(lines):
        cv2.putText(bar, line, (4, 18 + 20 * number), cv2.FONT_HERSHEY_SIMPLEX, SCALE, (20, 20, 20), 1, cv2.LINE_AA)
    return np.concatenate([image, bar])


def contact_sheet(frames: Sequence[tuple[Frame, FrameRow]]) -> bytes:
    """A JPEG with the frames in which something changes, and others evenly between them, in order.

    Args:
        frames: All of an episode.
    """
    chosen = _telling([row for _, row in frames])
    tiles = [np.pad(told(*frames[k]), ((0, 6), (0, 6), (0, 0)), constant_values=255) for k in chosen]
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % min(COLUMNS, len(tiles)))
    across = min(COLUMNS, len(tiles))
    sheet = np.vstack([np.hstack(tiles[k : k + across]) for k in range(0, len(tiles), across)])
    encoded = cv2.imencode(".jpg", np.ascontiguousarray(sheet[:, :, ::-1]), [cv2.IMWRITE_JPEG_QUALITY, 80])[1]
    return bytes(encoded.tobytes())


def film(frames: Sequence[tuple[Frame, FrameRow]], *, frames_per_second: float) -> bytes:
    """An animated WebP of an episode, at the rate of its frames.

    Args:
        frames: All of it.
        frames_per_second: Rate [1/s].
    """
    first, *others = (Pillow.fromarray(told(image, row)) for image, row in frames)
    file = io.BytesIO()
    first.save(
        file, format="WEBP", save_all=True, append_images=others, duration=round(1000 / frames_per_second), quality=40,
        method=4, loop=0,
    )  # fmt: skip
    return file.getvalue()


def _telling(rows: Sequence[FrameRow]) -> npt.NDArray[np.int64]:
    """Numbers of the frames of a contact sheet."""
    marked = [0, len(rows) - 1]
    for number, (before, row) in enumerate(pairwise(rows), 1):
        if row.stage != before.stage or row.event or row.light != before.light:
            marked.append(number)
    chosen = sorted(set(marked))[:MOST]
    while len(chosen) < min(MOST, len(rows)):
        gaps = np.diff(chosen)
        widest = int(gaps.argmax())
        if gaps[widest] < 2:  # noqa: PLR2004 - neighbours
            break
        chosen = sorted([*chosen, chosen[widest] + int(gaps[widest]) // 2])
    return np.array(chosen)
