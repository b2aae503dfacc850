"""Verdicts as JSON or as lines of text, with the stage of the grasp state machine where it is asked for."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

from magicsim.detectors.grasp import GraspStage, GraspState, step_grasp
from magicsim.detectors.offline import stream_sources
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.sources.source import source_kind
from magicsim.detectors.verdict import NUMBERS, WORDS, Verdict
from magicsim.errors import ConfigError, visible

Row = Mapping[str, float | str | bool | None]
"""One frame's verdict ready for JSON; None is a word that is not judged."""

_CAMERA_WIDTH = 16


def write_verdicts(
    out: TextIO,
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile,
    *,
    frames: int | None = None,
    grasp: bool = False,
    as_json: bool = False,
) -> None:
    """Judge a source and write one row a frame: at the end, so that an error leaves nothing, a camera's as they come.

    Args:
        out: Where the rows go.
        source: What to judge, as in `detect_sources`.
        reference: The untouched sensor.
        profile: Name, path or profile.
        frames: Most frames to judge.
        grasp: Whether to run the grasp state machine over the frames too.
        as_json: One JSON object with the list `frames` instead of a table; a camera then needs `frames`.

    Raises:
        MagicsimError: What `detect_sources` raises.
    """
    endless = frames is None and source_kind(source) == "camera"
    if endless and as_json:
        msg = f"frames is missing: camera {source} never ends, so JSON needs the number of frames to judge"
        raise ConfigError(msg)
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    found = rows(stream_sources(source, reference, chosen, frames=frames), chosen, grasp=grasp)
    if not endless:
        whole = list(found)
        out.write(json_text(whole) if as_json else "".join(table_lines(whole, grasp=grasp)))
        return
    for line in table_lines(found, grasp=grasp, width=_CAMERA_WIDTH):
        out.write(line)
        out.flush()


def rows(verdicts: Iterable[Verdict], profile: DetectorProfile, *, grasp: bool = False) -> Iterator[Row]:
    """The verdicts' fields; with `grasp` also `stage` after the frame and `slip`, whether it showed one."""
    state = GraspState()
    for verdict in verdicts:
        if not grasp:
            yield verdict.as_dict()
            continue
        state = step_grasp(state, verdict, profile)
        yield {**verdict.as_dict(), "stage": str(state.stage), "slip": state.stage is GraspStage.SLIPPED}


def json_text(found: Sequence[Row], not_judged: str | None = None) -> str:
    """One JSON object with the list `frames` and, where there is something, `not_judged`; and a final newline."""
    told = {"frames": list(found)} | ({"not_judged": not_judged} if not_judged else {})
    return json.dumps(told, allow_nan=False) + "\n"


def table_lines(found: Iterable[Row], *, grasp: bool = False, width: int | None = None) -> Iterator[str]:
    """A heading, once there is a first row or none at all, and one line for each row.

    Args:
        found: The rows, a sequence where `width` is left out.
        grasp: Whether they have a `stage`.
        width: Columns for the source; those of the longest by default.
    """
    if width is None:
        found = list(found)
        width = max((len(str(row.get("source", ""))) for row in found), default=0)
    width = max(width, len("source"))
    following = iter(found)
    first = list(islice(following, 1))
    words = (*WORDS, *(["weak"] if first and "weak" in first[0] else []), *(["stage"] if grasp else []))
    yield _line([f"{'source':<{width}}", *(f"{name:>11}" for name in NUMBERS), *(f"{name:<11}" for name in words)])
    for row in chain(first, following):
        numbers = [f"{row[name]:>11.4f}" for name in NUMBERS]
        yield _line(
            [f"{row.get('source', ''):<{width}}", *numbers, *(f"{_word(name, row[name]):<11}" for name in words)]
        )


def _word(name: str, value: float | str | bool | None) -> str:
    return ("weak" if value else "-") if name == "weak" else str(value or "-")


def _line(cells: Sequence[str]) -> str:
    return visible("  ".join(cells).rstrip()) + "\n"
