"""What studies have in common that learn numbers from one dataset."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from magicsim.dataset.recipes.entries import PathRecipe
from magicsim_experiments.learn.fitting import ANSWERS, Read
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.learn.settings import PACKAGES
from magicsim_experiments.study.learned.answers import (
    Answers,
    answers_on_presses,
    beyond_rows,
    beyond_tables,
    checked_parts,
    read_answers,
)
from magicsim_experiments.study.learned.data import (
    LearnedConfig,
    count_objects,
    data_stages,
    learning_stage,
    refuse_few,
)
from magicsim_experiments.study.learned.error_tables import absolute_error, compared_table, curve_table, methods_table
from magicsim_experiments.study.protocol import Cell, Stage, StudyConfig, Table
from magicsim_experiments.study.stages import LearningStage


class LearnedStudy:
    """A study of one dataset and its models; a kind says what is learned, and what is made of the answers."""

    settings: ClassVar[type[StudyConfig]] = LearnedConfig
    packages: ClassVar[tuple[str, ...]] = PACKAGES
    read: ClassVar[Read]
    """Makes samples of a dataset; importable by name."""
    counted: ClassVar[Callable[[Sequence[PathRecipe]], int]]
    """Most frames of an episode on such paths that count."""
    large: ClassVar[dict[str, bool]] = {}
    """Large labels of the data that are needed."""
    knows_objects: ClassVar[bool] = False
    """Whether models are also tested on objects that they have not learned from."""

    def __init__(self, config: LearnedConfig) -> None:
        """Takes the settings, and lays out data and models."""
        self.config = config
        self.data = data_stages(config, self.large)
        recipe, kind = self.data[0].recipe, type(self)
        objects = count_objects(recipe) if self.knows_objects else 0
        frames = kind.counted(recipe.paths)
        self.learning = learning_stage(config, self.data, kind.read, frames_per_episode=frames, objects=objects)

    def refuse(self) -> None:
        """Refuses data that cannot be learned from."""
        refuse_few(self.config)

    def stages(self) -> Sequence[Stage]:
        """Data and models."""
        return [*self.data, self.learning]

    def seen(self, folder: Path) -> Answers:
        """Answers on unseen presses."""
        return answers_on_presses(folder, self.learning)

    def first_model(self, folder: Path, stage: LearningStage, name: str) -> Answers | None:
        """Answers of a stage's first model: on unseen presses of what it learned from, or on a further dataset."""
        file = ANSWERS if name == stage.dataset else f"answers-{name}.parquet"
        return read_answers(folder, replace(stage, fits=stage.fits[:1]), "press", file)

    def headline(self, seen: Answers, labels: Sequence[Label]) -> dict[str, Cell]:
        """Mean absolute error of the model by label and unit, and the number of frames."""
        errors: dict[Label, Cell] = {
            label: absolute_error(seen, "model", label, seed=self.config.seed).value for label in labels
        }
        return {f"{label.name}_{label.unit.lower()}": error for label, error in errors.items()} | {"frames": len(seen)}

    def beyond(self, folder: Path, labels: Sequence[Label]) -> tuple[Table, ...]:
        """What the learning curve promises of more frames; nothing of a curve of one point."""
        return beyond_tables(beyond_rows(folder, self.learning, labels, seed=self.config.seed))

    def number_tables(self, folder: Path, labels: Sequence[Label]) -> tuple[Table, Table, Table, Table]:
        """Errors of methods and on unseen units, the learning curve, what it rests on; of labels that are numbers."""
        seed, seen = self.config.seed, self.seen(folder)
        parts = {
            "presses on known units": seen, "unknown units": read_answers(folder, self.learning, "unit"),
            "unknown objects": read_answers(folder, self.learning, "object"),
        }  # fmt: skip
        return (
            methods_table(folder, self.learning, labels, seed=seed),
            compared_table(
                parts, labels, name="units", title="Unseen units", seed=seed,
                note="Units differ by the tolerances of the recipe, and by their room where it draws one.",
            ),
            curve_table(folder, self.learning, labels, seed=seed),
            compared_table(
                checked_parts(folder, self.learning, seen), labels, name="checks", title="What it rests on", seed=seed,
                note="The same presses without noise of the camera, and with four times the samples and particles.",
            ),
        )  # fmt: skip

    def facts(self, seen: Answers, what: str) -> dict[str, str]:
        """What the result was made of, in words."""
        presses, units = (len(np.unique(seen.column(name))) for name in ("press", "unit"))
        camera = self.data[0].recipe.rig.camera
        return {
            "Frames": f"{len(seen)} {what} of {presses} episodes",
            "Printed units": str(units),
            "Frames rendered at": f"{camera.columns} x {camera.rows} pixels",
            "Networks": ", ".join(self.config.learning.networks),
        }
