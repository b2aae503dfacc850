"""Verdicts on frames that exist and bring their own references: of a run, a dataset or a recording."""

from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

from magicsim.detectors.at_rest import features_at_rest, marked
from magicsim.detectors.combined import behind_coat, detect, detect_all
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.report import json_text, rows, table_lines
from magicsim.detectors.verdict import Verdict
from magicsim.errors import ConfigError
from magicsim.evaluation.takes.existing import read_existing
from magicsim.evaluation.takes.footage import Footage
from magicsim.judge.verdicts import COATED


def write_existing_verdicts(
    out: TextIO, folder: Path, profile: str | Path, *, frames: int | None = None, grasp: bool = False,
    as_json: bool = False,
) -> None:  # fmt: skip
    """Judges every frame after the references and writes one row a frame, as `magicsim.detectors.report` does.

    Behind an opaque coat proximity is left empty, and the last line, or `not_judged` in the JSON, says so.

    Args:
        out: Where the rows go.
        folder: A run of `simulate`, a dataset, or a recording with `truth.csv`.
        profile: Name or path.
        frames: Most frames to judge of all episodes together.
        grasp: Whether to run the grasp state machine over the frames of each episode too.
        as_json: One JSON object with the list `frames` instead of a table.

    Raises:
        MagicsimError: The folder, its frames or the profile cannot be used.
    """
    if frames is not None and frames < 1:
        msg = f"frames = {frames} is not allowed; must be a whole number of at least 1"
        raise ConfigError(msg)
    chosen = load_profile(profile)
    existing = read_existing(folder, frames_per_second=1.0)
    coated = existing.is_coated
    told = chain.from_iterable(
        rows(_verdicts(film, chosen, coated=coated), chosen, grasp=grasp) for film in existing.films
    )
    found = list(islice(told, frames))
    if coated:
        found = [{**row, "proximity": None} for row in found]
    not_judged = COATED if coated else None
    out.write(json_text(found, not_judged) if as_json else "".join(table_lines(found, grasp=grasp)))
    if coated and not as_json:
        out.write(f"not judged: {COATED}\n")


def _verdicts(film: Footage, profile: DetectorProfile, *, coated: bool) -> Iterator[Verdict]:
    untouched = list(islice(film.images.references(), profile.reference_count))
    references = fuse(untouched, profile)
    rest = features_at_rest(detect_all(untouched, references, profile))
    for number, frame in enumerate(film.images.frames()):
        verdict = detect(frame, references, profile, source=f"{film.tag.take}#{number}")
        yield marked(behind_coat(verdict) if coated else verdict, rest)
