"""What is made of an episode in its folder: verdicts, table, preview, page, and an MCAP file.

Animated preview of a stream: frames beside their changes, above a strip that says what is true and what was said.
"""

import importlib
import io
import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

from PIL import Image, ImageDraw, ImageFont

from magicsim.arrays import Frame
from magicsim.camera.projection import calibrate_camera
from magicsim.dataset.rows import frame_rows
from magicsim.detectors.verdict import Verdict
from magicsim.errors import ConfigError, FrameError
from magicsim.folder import result_file
from magicsim.judge.verdicts import COATED, PROFILES, TABLE, Judgement, judge, write_table
from magicsim.report.drawing import CLASS_COLORS
from magicsim.report.page import render_report
from magicsim.report.tables import write_caption
from magicsim.simulation.episode import Episode, SimulatedFrame

STRIP_WIDTH_PX = 200
"""Smallest width that the words need [px]."""
_LINE_PX = 16
_FONT_PX = 12
_PAPER = "#14181d"
_WORDS = "#e8ecf1"
_WRONG = "#ff9a4d"


def with_strip(shown: Frame, frame: SimulatedFrame, verdict: Verdict | None, *, scale: float = 1.0) -> Image.Image:
    """What is shown of a frame, shape (rows, columns, 3), above its strip."""
    picture = Image.fromarray(shown)
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
    said = write_caption(frame, verdict)
    place = f"frame {said.index}, {said.distance}" + (f", {said.force}" if frame.truth.contact else "")
    lines = [(place.replace("\u00a0", " "), False), (f"truth: {said.truth}", False)]
    for task, words, is_right in (
        ("proximity", said.proximity, said.proximity_right), ("contact", said.contact, said.contact_right)
    ):  # fmt: skip
        if words is not None:
            lines.append((f"{task}: {words}{' (wrong)' if is_right is False else ''}", is_right is False))
    return lines


PREVIEW_BYTES = 3_000_000
"""Size above which a preview is made with smaller pictures [bytes]."""
_SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)


def animate(
    episode: Episode, path: Path, *, verdicts: Sequence[Verdict] | None = None, max_bytes: int = PREVIEW_BYTES
) -> Path:
    """Write an animation (WebP) that loops, as large as `max_bytes` allows, at least at a quarter of the size.

    Without verdicts the strip states the truth alone.
    """
    frames = episode.scored
    said: Sequence[Verdict | None] = verdicts or [None] * len(frames)
    data, shown = b"", episode.on_screen(frames)
    for scale in _SCALES:
        pictures = [with_strip(*each, scale=scale) for each in zip(shown, frames, said, strict=True)]
        data = _encode(pictures, episode.scene.frames_per_second)
        if len(data) <= max_bytes:
            break
    with result_file(path) as partial:
        partial.write_bytes(data)
    return path


def _encode(pictures: Sequence[Image.Image], frames_per_second: float) -> bytes:
    ends = [round(1000.0 * k / frames_per_second) for k in range(len(pictures) + 1)]  # so that no errors add up [ms]
    buffer = io.BytesIO()
    pictures[0].save(
        buffer, format="WEBP", save_all=True, append_images=pictures[1:], loop=0, quality=80, method=2,
        duration=[max(1, later - earlier) for earlier, later in pairwise(ends)],
    )  # fmt: skip
    return buffer.getvalue()


LOGGER = logging.getLogger(__name__)
REPORT, PREVIEW, MCAP = "report.html", "preview.webp", "episode.mcap"


def report_episode(folder: Path, episode: Episode, facts: Mapping[str, str]) -> tuple[float, dict[str, Any]]:
    """Judges an episode with every standard profile, and adds to its folder what its scene's output asks for.

    Cost of judging [s], and how it was judged: fields of `magicsim.simulation.main_job.RunSummary`.
    """
    scene, start = episode.scene, time.perf_counter()
    judgements, refused = judged(episode)
    seconds = time.perf_counter() - start
    write_table(folder / TABLE, episode, judgements)
    if scene.output.preview:
        verdicts = judgements[0].verdicts if judgements else ()
        animate(episode, folder / PREVIEW, verdicts=verdicts)
    if scene.output.report:
        facts = dict(facts) | ({"Not judged": refused} if refused else {})
        (folder / REPORT).write_text(render_report(episode, judgements, facts), encoding="utf-8")
    if scene.output.mcap:
        write_mcap(folder / MCAP, episode)
    first = next((each for each in judgements if each.profile == PROFILES[0]), None)
    score = first.score if first else None
    return seconds, {
        "contact_accuracy": score.contact.accuracy if score else None,
        "proximity_accuracy": score.proximity.accuracy if score and not scene.design.is_opaque else None,
        "at_rest": {name: asdict(each) for name, each in first.at_rest.items()} if first else {},
        "not_judged": refused,
    }


def judged(episode: Episode) -> tuple[list[Judgement], str | None]:
    """Judgements of every standard profile, and what was not judged and why; None where all was.

    Detectors refuse a sensor that they cannot judge, such as one whose reference frames show no grid. That is no
    fault of the frames.
    """
    judgements, refusals = [], []
    if episode.references and episode.scene.design.is_opaque:
        refusals.append(COATED)
    for name in PROFILES if episode.references else ():
        try:
            judgements.append(judge(episode, name))
        except FrameError as error:
            refusals.append(f"profile '{name}': {error}")
            LOGGER.warning("no verdicts of profile '%s': %s; frames and truth are written without", name, error)
    return judgements, "; ".join(refusals) or None


def write_mcap(path: Path, episode: Episode) -> None:
    """Writes an episode as an MCAP file, see `magicsim.dataset.export.mcap`."""
    mcap = load_mcap()
    scene, window = episode.scene, episode.scene.rig.camera.window
    rows = frame_rows(episode.frames, scene, calibrate_camera(scene.design, scene.rig))
    mcap.write_mcap_episode(path, rows, size=(window.columns, window.rows), about={"seed": str(scene.seed)})


def load_mcap() -> ModuleType:
    """The writer of MCAP files; `ConfigError` where its package is not installed."""
    try:
        return importlib.import_module("magicsim.dataset.export.mcap")
    except ImportError as error:
        raise ConfigError(f"output.mcap = true needs the package {error.name}: pip install 'magicsim[mcap]'") from None
