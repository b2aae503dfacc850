"""Detection on sources: one to judge, one of references, and a profile's name; verdicts as JSON or lines of text."""

import json
import logging
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

from magicsim.detectors.combined import detect
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.grasp import GraspStage, GraspState, step_grasp
from magicsim.detectors.orientation import turned_against
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.references import said_of, told_of_references
from magicsim.detectors.source import SourceFrame, read_source, source_kind
from magicsim.detectors.verdict import (
    NUMBERS,
    WORDS,
    FeatureAtRest,
    Verdict,
    features_at_rest,
    marked,
)
from magicsim.errors import ConfigError, FrameError, visible
from magicsim.waiting import Told, on_stderr, waiting

_LOG = logging.getLogger(__name__)


def detect_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
    told: Told = on_stderr,
) -> list[Verdict]:
    """Judge every frame of a source.

    Logs a warning when there were fewer reference frames than asked for, or some that do not look untouched.

    Args:
        source: Image file, folder of images, video file, or index of a camera.
        reference: The same, of the untouched sensor; its first `reference_count` frames are taken.
        profile: Shipped name, path of a TOML file, or a profile itself.
        frames: Most frames to judge; needed for a camera, which never ends.
        told: Hears what takes longer than two seconds.

    Returns:
        One verdict for each frame, with the frame's name.

    Raises:
        ConfigError: A source does not exist or holds no image, a camera without `frames`, or the profile is not valid.
        PresetError: There is no such profile.
        FrameError: An image, a video or a camera cannot be used; the line names it.
    """
    if frames is None and source_kind(source) == "camera":
        raise ConfigError(f"frames is missing: camera {source} never ends; give the number of frames to judge")
    with waiting("judging frames", told):
        return list(stream_sources(source, reference, profile, frames=frames))


def stream_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
) -> Iterator[Verdict]:
    """Judge a source like `detect_sources`, one verdict at a time: a camera for as long as it runs."""
    if frames is not None and frames < 1:
        raise ConfigError(f"frames = {frames} is not allowed; must be a whole number of at least 1")
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    with closing(read_source(source)) as judged:
        references, resting = fuse_source(reference, chosen)
        for number, each in enumerate(islice(judged, frames)):
            with _naming(each):
                verdict = detect(each.image, references, chosen, source=each.name)
            if number == 0 and (turned := turned_against(references.background.ceiling, [each.image])):
                _LOG.warning("%s", turned)
            yield marked(verdict, resting)
    if references.grid.frames < chosen.reference_count:
        _LOG.warning("%d reference frames instead of %d", references.grid.frames, chosen.reference_count)


def fuse_source(reference: str | Path, profile: DetectorProfile) -> tuple[References, dict[str, FeatureAtRest]]:
    """References from the first frames of a source of the untouched sensor, and what E, C and S are on these."""
    with closing(_reference_images(reference)) as images:
        taken = list(islice(images, profile.reference_count))
    for odd in told_of_references(taken, said_of(taken, profile)):
        _LOG.warning("%s", odd)
    references = fuse(taken, profile)
    verdicts = [detect(image, references, profile) for image in taken]
    return references, features_at_rest(verdicts)


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
    grasp: bool = False,
    as_json: bool = False,
) -> None:
    """Judge a source and write one row a frame: at the end, so that an error leaves nothing; a camera's at once."""
    endless = frames is None and source_kind(source) == "camera"
    if endless and as_json:
        raise ConfigError(f"frames is missing: camera {source} never ends, so JSON needs the number of frames to judge")
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    judged = rows(stream_sources(source, reference, chosen, frames=frames), chosen, grasp=grasp)
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
        if not grasp:
            yield verdict.as_dict()
            continue
        state = step_grasp(state, verdict, profile)
        yield {**verdict.as_dict(), "stage": str(state.stage), "slip": state.stage is GraspStage.SLIPPED}


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
