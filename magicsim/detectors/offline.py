"""Detection on sources: one to judge, one of references, and a profile's name; verdicts as JSON or lines of text."""

import json
import logging
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

import numpy as np
import numpy.typing as npt

from magicsim.detectors.combined import detect, detect_all, followed
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.grasp import GraspStage, GraspState, step_grasp
from magicsim.detectors.orientation import turned_against
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import fuse, with_touches
from magicsim.detectors.source import SourceFrame, read_source, source_kind
from magicsim.detectors.verdict import (
    NUMBERS,
    WORDS,
    Contact,
    Proximity,
    Verdict,
    features_at_rest,
    marked,
)
from magicsim.errors import ConfigError, FrameError, visible
from magicsim.waiting import Told, on_stderr, waiting

_LOG = logging.getLogger(__name__)
MOST_RATIO = 1.1
"""Brightness of one channel over that of the others that is told."""
MOST_DRIFT = 0.03
"""Difference of a reference's brightness from the usual one that is told."""
MOST_TOUCHES = 255
"""Frames of touches that are read at most."""
LEAST_MEAN = 10.0
"""Mean grey level below which a frame is black."""


def detect_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
    touches: str | Path | None = None,
    told: Told = on_stderr,
) -> list[Verdict]:
    """Judge every frame of a source: one verdict for each, with the frame's name.

    Logs a warning when there were fewer reference frames than asked for, or some that do not look untouched.

    Args:
        source: Image file, folder of images, video file, or index of a camera.
        reference: The same, of the untouched sensor; its first `reference_count` frames are taken.
        profile: Shipped name, path of a TOML file, or a profile itself.
        frames: Most frames to judge; needed for a camera, which never ends.
        touches: The sensor's own first one to three touches, for a profile with `units = "rest"`.
        told: Hears what takes longer than two seconds.

    Raises:
        ConfigError: A source does not exist or holds no image, a camera without `frames`, or the profile is not valid.
        PresetError: There is no such profile.
        FrameError: An image, a video or a camera cannot be used; the line names it.
    """
    if frames is None and source_kind(source) == "camera":
        raise ConfigError(f"frames is missing: camera {source} never ends; give the number of frames to judge")
    with waiting("judging frames", told):
        return list(stream_sources(source, reference, profile, frames=frames, touches=touches))


def stream_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
    touches: str | Path | None = None,
) -> Iterator[Verdict]:
    """Judge a source like `detect_sources`, one verdict at a time: a camera for as long as it runs."""
    if frames is not None and frames < 1:
        raise ConfigError(f"frames = {frames} is not allowed; must be a whole number of at least 1")
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    with closing(read_source(source)) as judged:
        with closing(_reference_images(reference)) as images:
            untouched = list(islice(images, chosen.reference_count))
        for odd in told_of_references(untouched, said_of(untouched, chosen)):
            _LOG.warning("%s", odd)
        references = fuse(untouched, chosen)
        if touches is not None:  # which change the units of S
            with closing(_reference_images(touches)) as images:
                references = with_touches(references, list(islice(images, MOST_TOUCHES)), chosen)
        resting = features_at_rest([detect(each, references, chosen) for each in untouched])
        for number, each in enumerate(islice(judged, frames)):
            with _naming(each):
                verdict = detect(each.image, references, chosen, source=each.name)
            if number == 0 and (turned := turned_against(references.background.ceiling, [each.image])):
                _LOG.warning("%s", turned)
            references = followed(references, verdict, chosen)
            yield marked(verdict, resting)
    if references.grid.frames < chosen.reference_count:
        _LOG.warning("%d reference frames instead of %d", references.grid.frames, chosen.reference_count)


def told_of_references(untouched: Sequence[Frame], said: Sequence[tuple[str, str]]) -> Iterator[str]:
    """One line for each way in which frames are no references: black, coloured, drifting, or not untouched.

    `untouched` are RGB frames; `said` are verdicts on proximity and, with everything known, on contact of each
    (`said_of`), none where nobody judges them.
    """
    yield from _told_of_looks(untouched)
    odd = [number for number, each in enumerate(said) if each != (Proximity.NORMAL, Contact.UNTOUCHED)]
    if odd:
        yield (
            f"{len(odd)} of {len(said)} reference frames do not look untouched beside the others, the first of them "
            f"frame {odd[0]} ({', '.join(said[odd[0]])}); references are frames of the untouched sensor"
        )


def said_of(untouched: Sequence[Frame], profile: DetectorProfile | None = None) -> list[tuple[str, str]]:
    """Verdicts of a profile, by default the published one, on references against each other.

    None where there are too few of them, or the profile sees no grid there.
    """
    chosen = profile or load_profile("published")
    try:
        verdicts = detect_all(untouched, fuse(untouched, chosen), chosen)
    except FrameError:
        return []
    return [(each.proximity, each.combined) for each in verdicts]


def _told_of_looks(untouched: Sequence[Frame]) -> Iterator[str]:
    means = np.array([each.mean((0, 1)) for each in untouched]) + 1
    if not len(means):
        return
    black = black_frames(means, means[np.argmax(means.sum(1))])
    if black:
        yield f"reference frames {_numbers(black)} are black: leave out what a camera gives before it is ready"
    lit = [number for number in range(len(means)) if number not in black]
    if not lit:
        return
    shares = means[lit] / np.median(means[lit], 0)
    levels = np.median(shares, 1)
    tints = (shares.max(1) / shares.min(1)) > MOST_RATIO
    if coloured := [number for number, is_tinted in zip(lit, tints, strict=True) if is_tinted]:
        yield f"reference frames {_numbers(coloured)} have other colours than the rest: lock the white balance"
    drifting = [
        number
        for number, level, is_tinted in zip(lit, levels, tints, strict=True)
        if abs(level - 1) > MOST_DRIFT and not is_tinted
    ]
    if drifting:
        span = f"{100 * levels.min():.0f} to {100 * levels.max():.0f} %"
        yield (
            f"references drift, with {span} of their usual brightness (frames {_numbers(drifting)}): lock the "
            "exposure, and leave out the first frames"
        )


def black_frames(means: npt.NDArray[np.float64], usual: npt.NDArray[np.float64]) -> list[int]:
    """Numbers of frames that are black beside a usual one, by mean grey levels of shape (frames, 3)."""
    return np.flatnonzero(means.mean(1) < min(LEAST_MEAN, usual.mean() / 2)).tolist()


def _numbers(numbers: Sequence[int]) -> str:
    """Numbers as a text, the first three and how many there are."""
    shown = ", ".join(map(str, numbers[:3]))
    return shown if len(numbers) <= 3 else f"{shown} and {len(numbers) - 3} more"  # noqa: PLR2004


def _reference_images(reference: str | Path) -> Generator[Frame, None, None]:
    """Images of the untouched sensor, all of the first one's size."""
    shape: tuple[int, ...] | None = None
    with closing(read_source(reference)) as frames:
        for each in frames:
            with _naming(each):
                image = check_frame(each.image, shape=shape)
            shape = image.shape
            yield image


@contextmanager
def _naming(frame: SourceFrame) -> Iterator[None]:
    """Add the frame's name to what is wrong with it."""
    try:
        yield
    except FrameError as error:
        raise FrameError(f"image '{frame.name}': {error}") from error


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
    touches: str | Path | None = None,
    grasp: bool = False,
    as_json: bool = False,
) -> None:
    """Judge a source and write one row a frame: at the end, so that an error leaves nothing; a camera's at once."""
    endless = frames is None and source_kind(source) == "camera"
    if endless and as_json:
        raise ConfigError(f"frames is missing: camera {source} never ends, so JSON needs the number of frames to judge")
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    judged = rows(stream_sources(source, reference, chosen, frames=frames, touches=touches), chosen, grasp=grasp)
    if not endless:
        whole = list(judged)
        out.write(json_text(whole) if as_json else "".join(table_lines(whole, grasp=grasp)))
        return
    for line in table_lines(judged, grasp=grasp, width=_CAMERA_WIDTH):
        out.write(line)
        out.flush()


def rows(verdicts: Iterable[Verdict], profile: DetectorProfile, *, grasp: bool = False) -> Iterator[Row]:
    """The verdicts' fields; with `grasp` also `stage` after the frame and `slip`, whether it showed one."""
    state = GraspState()
    for verdict in verdicts:
        row = verdict.as_dict()
        if grasp:
            state = step_grasp(state, verdict, profile)
            row |= {"stage": str(state.stage), "slip": state.stage is GraspStage.SLIPPED}
        yield row


def json_text(judged: Sequence[Row], not_judged: str | None = None) -> str:
    """One JSON object with the list `frames` and, where there is something, `not_judged`; and a final newline."""
    content = {"frames": list(judged)} | ({"not_judged": not_judged} if not_judged else {})
    return json.dumps(content, allow_nan=False) + "\n"


def table_lines(judged: Iterable[Row], *, grasp: bool = False, width: int | None = None) -> Iterator[str]:
    """A heading, once there is a first row or none at all, and one line for each row."""
    if width is None:
        judged = list(judged)
        width = max((len(str(row.get("source", ""))) for row in judged), default=0)
    width = max(width, len("source"))
    following = iter(judged)
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
