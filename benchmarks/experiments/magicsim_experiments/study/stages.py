"""Stages of studies: a dataset, pieces of other work, models; a run that was killed goes on where it was."""

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from magicsim.dataset.generate import Standing, generate_dataset
from magicsim.dataset.manifest import FailedEpisode, Manifest, read_manifest
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.estimate import estimate
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import OutputError
from magicsim.folder.ledger import WORK
from magicsim.folder.target import LOCK
from magicsim.workers.attempt import FailureKind, Outcome, Work, bound_threads
from magicsim.workers.run_folder import log_failures
from magicsim.workers.tasks import run_tasks
from magicsim_experiments.learn.fitting import (
    ANSWERS,
    MODEL,
    Also,
    Fit,
    FitOutcome,
    FitTask,
    Read,
    fit_stretch,
    prepare_learning,
)
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.protocol import DATA, MODELS, PIECES, Workshop


@dataclass(frozen=True, slots=True, kw_only=True)
class PiecesStage:
    """Calls a function on every task; what it returns for task k is the content of `pieces/NAME/k`."""

    name: str
    function: Callable[[Any], bytes]
    """Importable by name; returns the content of the piece's file. A `MagicsimError` that it raises is a result too:
    the piece has none, and why."""
    tasks: Sequence[object]
    seconds: float
    """Rough time of a piece on one core [s]."""
    suffix: str = ".json"

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s]."""
        return self.seconds * len(self.tasks)

    def is_done(self, folder: Path) -> bool:
        """Whether every piece is there, or why it is not."""
        return not any(self._is_open(folder, number) for number in range(len(self.tasks)))

    def owns(self, name: str) -> bool:
        """None of the files: the study's own list has them."""
        return False

    def run(self, workshop: Workshop) -> None:
        """Computes what is not there yet."""
        left = [number for number in range(len(self.tasks)) if self._is_open(workshop.folder, number)]
        lost = []
        tasks = ((number, self.tasks[number]) for number in left)
        with closing(run_tasks(self.function, tasks, workshop.options, prepare=bound_threads)) as outcomes:
            outcome: Outcome[bytes]
            for done, outcome in enumerate(outcomes if left else (), len(self.tasks) - len(left) + 1):
                log_failures(workshop.folder, self.name, outcome.key, outcome.failures)
                last = outcome.failures[-1] if outcome.failures else None
                if outcome.result is not None:
                    workshop.place(self._file(outcome.key), outcome.result)
                elif last is not None and last.kind is FailureKind.REFUSED:
                    content = json.dumps({"message": last.message}, indent=1) + "\n"
                    workshop.place(_refusal(self.name, outcome.key), content.encode())
                else:
                    lost.append(last.message if last is not None else "no result")
                workshop.tell(done / len(self.tasks), f"{self.name}: {done} of {len(self.tasks)}")
        if lost:
            msg = f"{len(lost)} pieces of '{self.name}' have no result ({lost[0]}); --resume tries them again"
            raise OutputError(msg)

    def _file(self, number: int) -> str:
        return f"{PIECES}/{self.name}/{number:05d}{self.suffix}"

    def _is_open(self, folder: Path, number: int) -> bool:
        return not ((folder / self._file(number)).is_file() or (folder / _refusal(self.name, number)).is_file())


def read_pieces(folder: Path, stage: PiecesStage) -> list[bytes | None]:
    """Content of every piece of a finished stage, in order; None where it was refused."""
    place = folder / PIECES / stage.name
    return [_content(place / f"{number:05d}{stage.suffix}") for number in range(len(stage.tasks))]


def read_refusals(folder: Path, stage: PiecesStage) -> dict[int, str]:
    """Why pieces of a finished stage have no content, by number."""
    found = {number: _content(folder / _refusal(stage.name, number)) for number in range(len(stage.tasks))}
    return {number: str(json.loads(content)["message"]) for number, content in found.items() if content is not None}


def _refusal(stage: str, number: int) -> str:
    return f"{PIECES}/{stage}/{number:05d}.refused.json"


def _content(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None


@dataclass(frozen=True, slots=True, kw_only=True)
class DatasetStage:
    """Writes one dataset."""

    name: str
    recipe: Recipe
    simulator: Work | None = None
    """What makes rows, where it is not the simulation."""

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s]."""
        return estimate(self.recipe, draw_episodes(self.recipe), processes=processes).core_seconds

    def is_done(self, folder: Path) -> bool:
        """Whether the dataset is whole and of this recipe; episodes without a valid answer do not count."""
        manifest = read_manifest(dataset_folder(folder, self.name))
        return (
            manifest is not None
            and manifest.is_complete
            and manifest.config_hash == self.recipe.config_hash()
            and bool(manifest.shards)
            and not _lost(manifest)
        )

    def owns(self, name: str) -> bool:
        """Whether a file is in the dataset's folder, or its lock."""
        return name.startswith(f"{DATA}/{self.name}/") or name == f"{DATA}/.{self.name}.{LOCK}"

    def run(self, workshop: Workshop) -> None:
        """Simulates what is left.

        Raises:
            OutputError: The folder holds a dataset of another recipe, no episode has rows, or some failed for a reason
                that may pass.
        """
        start, folder = time.monotonic(), dataset_folder(workshop.folder, self.name)

        def tell(standing: Standing) -> None:
            failed = f", {standing.failed} failed" if standing.failed else ""
            rate = standing.frames / max(time.monotonic() - start, 1e-6)
            workshop.tell(standing.done / standing.total, f"{self.name}: {rate:.2f} frames/s{failed}")

        found = generate_dataset(
            self.recipe, folder, options=workshop.options, resume=True, simulator=self.simulator, progress=tell
        )
        manifest = read_manifest(folder)
        lost = _lost(manifest) if manifest is not None else []
        if lost:
            msg = f"{len(lost)} episodes of '{self.name}' have no frames ({lost[0].message}); --resume tries them again"
            raise OutputError(msg)
        if not found.samples:
            raise OutputError(f"no episode of '{self.name}' has frames: see its errors.jsonl")


def _lost(manifest: Manifest) -> list[FailedEpisode]:
    """Episodes that failed for a reason that may pass."""
    return [each for each in manifest.failed if each.kind != "refused"]


def dataset_folder(study: Path, name: str) -> Path:
    """Folder of one of a study's datasets."""
    return study / DATA / name


START_S = 6.0
"""Core seconds that a stretch needs to load PyTorch and the frames."""
PIXEL_S = {"small": 2e-7, "resnet18": 5e-6}
"""Core seconds of a pixel of a training frame in a pass, by network; of one x86-64 core."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LearningStage:
    """Trains models; what each leaves is in `models/STAGE/FIT`."""

    name: str
    fits: tuple[Fit, ...]
    dataset: str
    """Name of the stage whose dataset they learn from."""
    recipe: Recipe
    read: Read
    settings: LearningSettings
    frames: int
    """How many frames there are, about."""
    study: str
    seed: int
    also: Mapping[str, bool] = field(default_factory=dict)
    """Further datasets to answer on: names of their stages, and whether their presses are those of the training."""
    start: tuple[str, str] | None = None
    """Stage and fit whose model every fit begins with, instead of random weights."""
    stretch_s: float = 60.0
    """Processor time between two checkpoints of a model [s]."""

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s], if every model takes two thirds of its passes."""
        camera, longest = self.recipe.rig.camera, self.settings.long_side_px or math.inf
        pixels = camera.rows * camera.columns * min(1.0, longest / max(camera.rows, camera.columns)) ** 2
        passes = 2 / 3 * self.settings.epochs * self.frames * pixels
        return sum(START_S + passes * PIXEL_S[fit.network] * fit.share for fit in self.fits)

    def is_done(self, folder: Path) -> bool:
        """Whether every model is there."""
        return not any(self._is_open(folder, fit) for fit in self.fits)

    def owns(self, name: str) -> bool:
        """None of the files: the study's own list has them."""
        return False

    def folder(self, study: Path, fit: Fit) -> Path:
        """What a fit has left."""
        return study / MODELS / self.name / fit.name

    def run(self, workshop: Workshop) -> None:
        """Trains what is left, in rounds of a stretch each."""
        shares = [0.0 if self._is_open(workshop.folder, fit) else 1.0 for fit in self.fits]
        while left := [number for number, fit in enumerate(self.fits) if self._is_open(workshop.folder, fit)]:
            tasks = ((number, self._task(workshop.folder, number)) for number in left)
            with closing(run_tasks(fit_stretch, tasks, workshop.options, prepare=prepare_learning)) as outcomes:
                outcome: Outcome[FitOutcome]
                for outcome in outcomes:
                    log_failures(workshop.folder, self.name, outcome.key, outcome.failures)
                    if outcome.result is None:
                        msg = f"model '{self.fits[outcome.key].name}' was not trained: {outcome.failures[-1].message}"
                        raise OutputError(msg)
                    self._take(workshop, self.fits[outcome.key], outcome.result)
                    shares[outcome.key] = 1.0 if outcome.result.checkpoint is None else outcome.result.share
                    note = f"{self.name}: {sum(each == 1.0 for each in shares)} of {len(shares)} models"
                    workshop.tell(sum(shares) / len(shares), note)

    def _take(self, workshop: Workshop, fit: Fit, found: FitOutcome) -> None:
        if found.checkpoint is not None:
            workshop.place(self._checkpoint(fit), found.checkpoint)
            return
        place = f"{MODELS}/{self.name}/{fit.name}"
        for name in sorted(found.files, key=lambda each: each == ANSWERS):
            # The answers come last: they say that the fit is whole.
            workshop.place(f"{place}/{name}", found.files[name])
        workshop.remove(self._checkpoint(fit))

    def _task(self, folder: Path, number: int) -> FitTask:
        fit = self.fits[number]
        checkpoint = folder / self._checkpoint(fit)
        start = None if self.start is None else (folder / MODELS / "/".join(self.start) / MODEL).read_bytes()
        return FitTask(
            fit=fit, settings=self.settings, read=self.read, folder=dataset_folder(folder, self.dataset).resolve(),
            frame_size=(self.recipe.rig.camera.rows, self.recipe.rig.camera.columns),
            recipe_hash=self.recipe.config_hash(), study=self.study, seed=self.seed, seconds=self.stretch_s,
            also=tuple(
                Also(name=name, folder=dataset_folder(folder, name).resolve(), same_presses=same)
                for name, same in self.also.items()
            ),
            checkpoint=checkpoint.read_bytes() if checkpoint.is_file() else None, start=start,
        )  # fmt: skip

    def _checkpoint(self, fit: Fit) -> str:
        return f"{WORK}/{self.name.replace('/', '-')}-{fit.name}.checkpoint"

    def _is_open(self, folder: Path, fit: Fit) -> bool:
        return not (self.folder(folder, fit) / ANSWERS).is_file()
