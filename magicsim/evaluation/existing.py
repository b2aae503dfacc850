"""Frames that exist: a run of `simulate`, a dataset, or a recording, as footage and with verdicts."""

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from magicsim.arrays import Frame
from magicsim.config.models import validate
from magicsim.config.named_files import read_with_paths
from magicsim.dataset.export.source import open_dataset
from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.dataset.manifest import MANIFEST
from magicsim.detectors.features import Episode
from magicsim.detectors.offline import json_text, rows, table_lines, told_of_references
from magicsim.detectors.picture import read_image
from magicsim.detectors.profile import load_profile
from magicsim.detectors.verdict import Verdict
from magicsim.errors import ConfigError
from magicsim.evaluation.answers import not_turned
from magicsim.evaluation.footage import Footage, recorded_footage
from magicsim.evaluation.suite import SuiteConfig, SuitePlace, SuiteRecording
from magicsim.folder import MARKER
from magicsim.frame_class import scored_class
from magicsim.judge.plausible import force_size
from magicsim.judge.recorded import LABELS, TRUTH, read_episode, read_recording
from magicsim.judge.tally import FIRST_PLACE, RECORDED, SIMULATED, EpisodeLabels, EpisodeTag
from magicsim.judge.verdicts import COATED, SensorDetector, read_table
from magicsim.judge.verdicts import TABLE as RUN
from magicsim.scenes.scene import SceneConfig

_LOG = logging.getLogger(__name__)
AS_MADE = "as-made"
"""Light, noise and place of frames that exist: those that they were made with."""
COLUMNS = (
    "image", "is_reference", "frame_class", "gap_mm", "force_n", "flashlight", "path_kind", "object_kind", "episode",
    "time_s", "version",
)  # fmt: skip
RECORDING = "recording"
"""Name of a recording that stands in no suite."""
SHOWN = "none"
"""Object of an episode without one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredImages:
    """Images that are read when they are asked for."""

    read: Callable[[bool], Iterator[Frame]]
    """Takes whether references are wanted, or the frames after them."""

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return self.read(True)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return self.read(False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Existing:
    """Labelled episodes of a folder."""

    films: list[Footage]
    sensor: Mapping[str, Any]
    """Fields of a suite that stands for their sensor; empty where nothing describes it."""

    @property
    def is_coated(self) -> bool:
        """Whether an opaque coat hides from the sensor what is outside, as far as is known."""
        return "design" in self.sensor and self.sensor["design"].is_opaque


def is_existing(folder: Path) -> bool:
    """Whether a folder holds labelled frames that bring their own references."""
    return any((folder / name).is_file() for name in (RUN, MANIFEST, TRUTH, LABELS))


def read_existing(folder: Path, *, frames_per_second: float) -> Existing:
    """The episodes of a run, a dataset or a labelled recording, whose images are read when they are asked for.

    `ConfigError` where it is none of these or has no references to learn from, `OutputError` where a dataset is not
    finished.
    """
    if (folder / RUN).is_file():
        scene = validate(SceneConfig, read_with_paths(folder / MARKER), source=MARKER)
        sensor = {"design": scene.design, "rig": scene.rig, "frames_per_second": scene.frames_per_second}
        return Existing(films=[_run(folder, scene)], sensor=sensor)
    if (folder / MANIFEST).is_file():
        source = open_dataset(folder)
        rate = source.frames_per_second or frames_per_second
        if source.recorded is not None:
            return Existing(films=_dataset(folder, rate, is_recorded=True), sensor={"frames_per_second": rate})
        recipe = source.recipe
        films = _dataset(folder, rate, is_recorded=False, gamma=recipe.rig.camera.gamma)
        return Existing(films=films, sensor={"design": recipe.design, "rig": recipe.rig, "frames_per_second": rate})
    if (folder / TRUTH).is_file() or (folder / LABELS).is_file():
        tag = _tag(RECORDING, folder.resolve().name, RECORDED, sensor=RECORDED)
        film = recorded_footage(read_recording(folder), tag, frames_per_second=frames_per_second)
        return Existing(films=[film], sensor={})
    kinds = f"{RUN} (a run), {MANIFEST} (a dataset), {TRUTH} or {LABELS}"
    raise ConfigError(f"'{folder}' holds no labelled frames; give a folder with {kinds}")


def existing_footage(folder: Path, suite: SuiteConfig) -> tuple[SuiteConfig, list[Footage]]:
    """The labelled episodes of `read_existing`, and the suite that stands for them: its options, on their sensor."""
    existing = read_existing(folder, frames_per_second=suite.frames_per_second)
    kept = (SuiteRecording(name=RECORDING, folder=str(folder)),) if not existing.sensor else ()
    emptied: dict[str, Any] = dict.fromkeys(("objects", "paths", "lights", "episodes"), ())
    emptied |= {"recordings": kept, "places": (SuitePlace(name=FIRST_PLACE),), "rest_s": 0.0}
    return suite.model_copy(update=emptied | dict(existing.sensor)), existing.films


def labelled_episodes(folder: Path) -> list[Episode]:
    """All labelled episodes of a folder in memory, as `magicsim.judge.profile_fit.calibrate` takes them."""
    if not (folder / MANIFEST).is_file():
        return [read_episode(folder)]
    return [
        Episode(
            references=list(film.images.references()), frames=list(film.images.frames()), classes=film.labels.classes
        )
        for film in read_existing(folder, frames_per_second=1.0).films
    ]


def _run(folder: Path, scene: SceneConfig) -> Footage:
    rows = read_table(folder, ("file", "is_reference", "gap_mm", "force_n", "flashlight"))
    scored = [row for row in rows if not row["is_reference"]]
    _check_references(folder, len(rows) - len(scored))
    return Footage(
        tag=_tag(folder.resolve().name, scene.object.kind if scene.object is not None else SHOWN, "scene"),
        labels=EpisodeLabels.of(
            np.array([row["gap_mm"] for row in scored], float),
            np.linalg.norm(np.array([row["force_n"] for row in scored], float).reshape(-1, 3), axis=1),
            np.array([row["flashlight"] for row in scored], bool),
        ),
        images=StoredImages(
            read=lambda wanted: (read_image(folder / row["file"]) for row in rows if row["is_reference"] is wanted)
        ),
        frames_per_second=scene.frames_per_second,
        gamma=scene.rig.camera.gamma,
    )


def _dataset(folder: Path, frames_per_second: float, *, is_recorded: bool, gamma: float | None = None) -> list[Footage]:
    frames = open_frames(folder, COLUMNS)
    if len(made_by := np.unique(frames.column("version"))) > 1:
        first, other = (set(each.split(", ")) for each in made_by[:2].tolist())
        differing = ", ".join(sorted(first ^ other))
        raise ConfigError(f"'{folder}' holds rows of two versions of the code: {differing}; make the dataset again")
    episodes, is_reference = frames.column("episode"), frames.column("is_reference")
    films = []
    for number in np.unique(episodes).tolist():
        mine = episodes == number
        _check_references(folder, int((mine & is_reference).sum()))
        scored = frames.where(mine & ~is_reference)
        if not len(scored):
            continue
        gap_mm, flashlight = scored.column("gap_mm").astype(float), scored.column("flashlight")
        forces = scored.column("force_n").astype(float)
        if is_recorded:  # parts may be unknown, and its classes rest on more than gap and force
            sizes = [force_size(each[2:] if np.isnan(each[:2]).all() else each) for each in forces]
            labels = EpisodeLabels.of(gap_mm, np.array(sizes), flashlight)
            given = [scored_class(each) for each in scored.column("frame_class").tolist()]
            labels = replace(labels, classes=tuple(given))
        else:
            labels = EpisodeLabels.of(gap_mm, np.linalg.norm(forces, axis=1), flashlight)
        images = StoredImages(read=partial(_row_images, scored, frames.where(mine & is_reference)))
        body, path = (str(scored.column(name)[0]) for name in ("object_kind", "path_kind"))
        tag = _tag(f"episode-{number}", body or SHOWN, path, sensor=RECORDED if is_recorded else SIMULATED)
        films.append(Footage(tag=tag, labels=labels, images=images, frames_per_second=frames_per_second, gamma=gamma))
    return films


def _row_images(scored: FrameTable, references: FrameTable, wanted: bool) -> Iterator[Frame]:
    return (row["image"] for row in (references if wanted else scored))


def _tag(take: str, body: str, path: str, *, sensor: str = SIMULATED) -> EpisodeTag:
    return EpisodeTag(take=take, object=body, role="held_out", path=path, light=AS_MADE, noise=AS_MADE, sensor=sensor)


def _check_references(folder: Path, count: int) -> None:
    if count == 0:
        msg = f"'{folder}' has no reference frames, which detectors learn from: make it with references above 0"
        raise ConfigError(msg)


def write_existing_verdicts(
    out: TextIO, folder: Path, profile: str | Path, *, frames: int | None = None, grasp: bool = False,
    as_json: bool = False,
) -> None:  # fmt: skip
    """Judges every frame after the references and writes one row a frame, as `magicsim.detectors.offline` does.

    Behind an opaque coat proximity is left empty, and the last line, or `not_judged` in the JSON, says so.
    """
    if frames is not None and frames < 1:
        raise ConfigError(f"frames = {frames} is not allowed; must be a whole number of at least 1")
    chosen = load_profile(profile)
    existing = read_existing(folder, frames_per_second=1.0)
    coated = existing.is_coated

    def verdicts(film: Footage) -> Iterator[Verdict]:
        untouched = list(islice(film.images.references(), chosen.reference_count))
        detector = SensorDetector.of(untouched, chosen, is_coated=coated)
        said = [detector.verdict(each) for each in untouched]
        for odd in told_of_references(untouched, [(each.proximity, each.combined) for each in said]):
            _LOG.warning("%s: %s", film.tag.take, odd)
        frames = not_turned(film.images.frames(), untouched, film.tag.take)
        for number, verdict in enumerate(detector.verdicts(frames)):
            yield replace(verdict, source=f"{film.tag.take}#{number}")

    judged = chain.from_iterable(rows(verdicts(film), chosen, grasp=grasp) for film in existing.films)
    table = [{**row, "proximity": None} if coated else row for row in islice(judged, frames)]
    out.write(json_text(table, COATED if coated else None) if as_json else "".join(table_lines(table, grasp=grasp)))
    if coated and not as_json:
        out.write(f"not judged: {COATED}\n")
