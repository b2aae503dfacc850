"""A stage that trains models on one dataset, in stretches, so that a run that was killed loses a minute of each."""

from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import OutputError
from magicsim.folder.ledger import WORK
from magicsim.workers.attempt import Outcome
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
from magicsim_experiments.study.protocol import MODELS, Workshop
from magicsim_experiments.study.stages.dataset_stage import dataset_folder

START_S = 6.0
"""Core seconds that a stretch needs to load PyTorch and the frames."""
PIXEL_S = {"small": 2e-7, "resnet18": 5e-6}
"""Core seconds of a pixel of a training frame in a pass, by network; of one x86-64 core."""
REDUCED = 4800
"""Pixels of a reduced frame, where they are not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LearningStage:
    """Trains models; what each leaves is in `models/STAGE/FIT`."""

    name: str
    fits: tuple[Fit, ...]
    dataset: str
    """Name of the stage whose dataset they learn from."""
    recipe: Recipe
    """Recipe of that dataset."""
    read: Read
    """Makes samples of it."""
    settings: LearningSettings
    frames: int
    """How many frames there are, about."""
    study: str
    seed: int
    also: tuple[tuple[str, str, bool], ...] = ()
    """Further datasets to answer on: a name, the dataset's stage, and whether its presses are those of the training."""
    start: tuple[str, str] | None = None
    """Stage and fit whose model every fit begins with, instead of random weights."""
    stretch_s: float = 60.0
    """Processor time between two checkpoints of a model [s]."""

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s], if every model takes two thirds of its passes."""
        pixels = REDUCED if self.settings.long_side_px == 0 else 0.75 * self.settings.long_side_px**2
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
            workshop.ledger.place(self._checkpoint(fit), found.checkpoint)
            return
        place = f"{MODELS}/{self.name}/{fit.name}"
        for name in sorted(found.files, key=lambda each: each == ANSWERS):
            # The answers come last: they say that the fit is whole.
            workshop.ledger.place(f"{place}/{name}", found.files[name])
        workshop.ledger.remove(self._checkpoint(fit))

    def _task(self, folder: Path, number: int) -> FitTask:
        fit = self.fits[number]
        checkpoint = folder / self._checkpoint(fit)
        task = FitTask(
            fit=fit, settings=self.settings, read=self.read, folder=dataset_folder(folder, self.dataset).resolve(),
            frame_size=(self.recipe.rig.camera.rows, self.recipe.rig.camera.columns),
            recipe_hash=self.recipe.config_hash(), study=self.study, seed=self.seed, seconds=self.stretch_s,
            also=tuple(
                Also(name=name, folder=dataset_folder(folder, stage).resolve(), same_presses=same)
                for name, stage, same in self.also
            ),
        )  # fmt: skip
        if self.start is not None:
            task = replace(task, start=(folder / MODELS / self.start[0] / self.start[1] / MODEL).read_bytes())
        return replace(task, checkpoint=checkpoint.read_bytes() if checkpoint.is_file() else None)

    def _checkpoint(self, fit: Fit) -> str:
        return f"{WORK}/{self.name.replace('/', '-')}-{fit.name}.checkpoint"

    def _is_open(self, folder: Path, fit: Fit) -> bool:
        return not (self.folder(folder, fit) / ANSWERS).is_file()
