"""The strip below a preview's picture: frame number, gap or depth, force, true class, verdicts."""

import math

from PIL import Image, ImageDraw, ImageFont

from magicsim.detectors.verdict import Verdict
from magicsim.report.mistakes import contact_right, proximity_right
from magicsim.report.palette import CLASS_COLORS
from magicsim.report.text import gap_or_depth, quantity
from magicsim.simulation.episode import SimulatedFrame

STRIP_WIDTH_PX = 200
"""Smallest width that the words need [px]."""

_LINE_PX = 16
_FONT_PX = 12
_PAPER = "#14181d"
_WORDS = "#e8ecf1"
_WRONG = "#ff9a4d"


def with_strip(frame: SimulatedFrame, verdict: Verdict | None, *, scale: float = 1.0) -> Image.Image:
    """A frame's picture above its strip.

    Args:
        frame: What to show.
        verdict: What was said of it; None for the truth alone.
        scale: Factor on the picture's size; the words keep theirs.
    """
    picture = Image.fromarray(frame.image)
    size = (max(1, round(picture.width * scale)), max(1, round(picture.height * scale)))
    picture = picture if size == picture.size else picture.resize(size, Image.Resampling.LANCZOS)
    lines = strip_lines(frame, verdict)
    width = max(size[0], STRIP_WIDTH_PX)
    sheet = Image.new("RGB", (width, size[1] + _LINE_PX * len(lines) + 8), _PAPER)
    sheet.paste(picture, ((width - size[0]) // 2, 0))
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(_FONT_PX)
    truth = frame.truth.frame_class
    draw.rectangle((0, size[1], 5, sheet.height), fill=CLASS_COLORS[truth] if truth else _PAPER)
    for row, (words, wrong) in enumerate(lines):
        place = (11, size[1] + 4 + row * _LINE_PX)
        draw.text(place, words, font=font, fill=_WRONG if wrong else _WORDS)
    return sheet


def strip_lines(frame: SimulatedFrame, verdict: Verdict | None) -> list[tuple[str, bool]]:
    """The lines of words, each with whether it holds a wrong verdict."""
    truth = frame.truth
    told = str(truth.frame_class) if truth.frame_class else "not scored"
    distance = gap_or_depth(truth.state.gap_mm).replace("\u00a0", " ")
    force = quantity(math.hypot(*truth.force_n), "N").replace("\u00a0", " ")
    lines = [
        (f"frame {truth.index}, {distance}" + (f", {force}" if truth.contact else ""), False),
        (f"truth: {told}", False),
    ]
    if verdict is None:
        return lines
    wrong = [
        proximity_right(verdict, truth.frame_class) is False,
        contact_right(verdict, truth.frame_class) is False,
    ]
    mark = " (wrong)"
    return [
        *lines,
        (f"proximity: {verdict.proximity}{mark if wrong[0] else ''}", wrong[0]),
        (f"contact: {verdict.combined}{mark if wrong[1] else ''}", wrong[1]),
    ]
