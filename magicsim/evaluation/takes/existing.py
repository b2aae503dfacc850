"""Frames that exist as footage: a run of `simulate`, a dataset, or a recording of a real sensor."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pyarrow.parquet as pq

from magicsim.config.models import validate
from magicsim.config.toml_paths import read_with_paths
from magicsim.dataset.export.source import open_dataset
from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.dataset.manifest import MANIFEST
from magicsim.detectors.sources.source import read_image
from magicsim.errors import ConfigError
from magicsim.evaluation.suite import SuiteConfig, SuiteRecording
from magicsim.evaluation.takes.footage import RECORDED, EpisodeTag, Footage, Labels, recorded_footage
from magicsim.folder import MARKER
from magicsim.judge.recording import TABLE as TRUTH
from magicsim.judge.recording import read_recording
from magicsim.scenes.scene import SceneConfig

Frame = npt.NDArray[np.uint8]
RUN = "episode.parquet"
"""Table of a run, see `magicsim.judge.table`."""
AS_MADE = "as-made"
"""Light, noise and place of frames that exist: those that they were made with."""
COLUMNS = ("image", "is_reference", "gap_mm", "force_n", "flashlight", "path_kind", "object_kind", "episode", "time_s")
SHOWN = "none"
"""Object of an episode without one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunImages:
    """PNG files of a run."""

    folder: Path
    reference_files: tuple[str, ...]
    frame_files: tuple[str, ...]

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return (read_image(self.folder / name) for name in self.reference_files)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return (read_image(self.folder / name) for name in self.frame_files)


@dataclass(frozen=True, slots=True, kw_only=True)
class RowImages:
    """Rows of a dataset."""

    reference_rows: FrameTable
    frame_rows: FrameTable

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return (row["image"] for row in self.reference_rows)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return (row["image"] for row in self.frame_rows)


def existing_footage(folder: Path, suite: SuiteConfig) -> tuple[SuiteConfig, list[Footage]]:
    """The labelled episodes in a folder, and the suite that stands for them: its options, on their sensor.

    Args:
        folder: A run of `simulate`, a dataset, or a recording with `truth.csv`.
        suite: Whose options of measuring hold: resamples, seed, false-alarm rate.

    Raises:
        ConfigError: None of these, or frames without references to learn from.
        OutputError: A dataset that is not finished.
    """
    emptied = suite.model_copy(
        update={"objects": (), "paths": (), "lights": (), "episodes": (), "recordings": (), "rest_s": 0.0}
    )
    if (folder / RUN).is_file():
        scene = validate(SceneConfig, read_with_paths(folder / MARKER), source=MARKER)
        sensor = {"design": scene.design, "rig": scene.rig, "frames_per_second": scene.frames_per_second}
        return emptied.model_copy(update=sensor), [_run(folder, scene)]
    if (folder / MANIFEST).is_file():
        recipe = open_dataset(folder).recipe
        sensor = {"design": recipe.design, "rig": recipe.rig, "frames_per_second": recipe.frames_per_second}
        return emptied.model_copy(update=sensor), _dataset(folder, recipe.frames_per_second)
    if (folder / TRUTH).is_file():
        name = "recording"
        tag = _tag(name, folder.resolve().name, RECORDED)
        film = recorded_footage(read_recording(folder), tag, frames_per_second=suite.frames_per_second)
        kept = SuiteRecording(name=name, folder=str(folder))
        return emptied.model_copy(update={"recordings": (kept,)}), [film]
    msg = f"'{folder}' holds no labelled frames; give a folder with {RUN} (a run), {MANIFEST} (a dataset) or {TRUTH}"
    raise ConfigError(msg)


def _run(folder: Path, scene: SceneConfig) -> Footage:
    table = pq.read_table(folder / RUN, columns=["file", "is_reference", "gap_mm", "force_n", "flashlight"])
    rows = table.to_pylist()
    scored = [row for row in rows if not row["is_reference"]]
    references = tuple(row["file"] for row in rows if row["is_reference"])
    _check_references(folder, len(references))
    return Footage(
        tag=_tag(folder.resolve().name, scene.object.kind if scene.object is not None else SHOWN, "scene"),
        labels=Labels.of(
            np.array([row["gap_mm"] for row in scored], float),
            np.linalg.norm(np.array([row["force_n"] for row in scored], float).reshape(-1, 3), axis=1),
            np.array([row["flashlight"] for row in scored], bool),
        ),
        images=RunImages(folder=folder, reference_files=references, frame_files=tuple(row["file"] for row in scored)),
        frames_per_second=scene.frames_per_second,
    )


def _dataset(folder: Path, frames_per_second: float) -> list[Footage]:
    frames = open_frames(folder, COLUMNS)
    episodes, is_reference = frames.column("episode"), frames.column("is_reference")
    found = []
    for number in np.unique(episodes).tolist():
        mine = episodes == number
        _check_references(folder, int((mine & is_reference).sum()))
        scored = frames.where(mine & ~is_reference)
        kind = scored.column("object_kind")[0] or SHOWN
        labels = Labels.of(
            scored.column("gap_mm").astype(float),
            np.linalg.norm(scored.column("force_n"), axis=1),
            scored.column("flashlight"),
        )
        images = RowImages(reference_rows=frames.where(mine & is_reference), frame_rows=scored)
        tag = _tag(f"episode-{number}", str(kind), str(scored.column("path_kind")[0]))
        found.append(Footage(tag=tag, labels=labels, images=images, frames_per_second=frames_per_second))
    return found


def _tag(take: str, thing: str, path: str) -> EpisodeTag:
    return EpisodeTag(take=take, object=thing, role="held_out", path=path, light=AS_MADE, noise=AS_MADE)


def _check_references(folder: Path, count: int) -> None:
    if count == 0:
        msg = f"'{folder}' has no reference frames, which detectors learn from: make it with references above 0"
        raise ConfigError(msg)
