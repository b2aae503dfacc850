"""What studies have in common that learn numbers from one dataset."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np

from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import OutputError
from magicsim.learn.fitting import Read
from magicsim.learn.packages import PACKAGES
from magicsim.learn.samples import Label
from magicsim.study.learned.answers import Answers, checked_parts, read_answers
from magicsim.study.learned.data import count_objects, data_stages, learning_stage, refuse_few
from magicsim.study.learned.error_tables import compared_table, curve_figures, curve_table, methods_table
from magicsim.study.learned.settings import LearnedConfig
from magicsim.study.protocol import Stage
from magicsim.study.result import Figure, Table
from magicsim.study.settings import StudyConfig


class LearnedStudy:
    """A study of one dataset and its models; a kind says what is learned, and what is made of the answers."""

    settings: ClassVar[type[StudyConfig]] = LearnedConfig
    packages: ClassVar[tuple[str, ...]] = PACKAGES
    large: ClassVar[dict[str, bool]] = {}
    """Large labels of the data that are needed."""
    knows_objects: ClassVar[bool] = False
    """Whether models are also tested on objects that they have not learned from."""

    def __init__(self, config: LearnedConfig) -> None:
        """Takes the settings, and lays out data and models."""
        self.config = config
        self.data = data_stages(config, self.large)
        frames = self.frames_per_episode(self.data[0].recipe)
        self.learning = learning_stage(
            config, self.data, self.reader(), frames_per_episode=frames,
            objects=count_objects(self.data[0].recipe) if self.knows_objects else 0,
        )  # fmt: skip

    @classmethod
    def reader(cls) -> Read:
        """What makes samples of a dataset; importable by name."""
        raise NotImplementedError

    @staticmethod
    def frames_per_episode(recipe: Recipe) -> int:
        """Most frames of an episode that count."""
        raise NotImplementedError

    def refuse(self) -> None:
        """Refuses data that cannot be learned from.

        Raises:
            ConfigError: With what is wrong.
        """
        refuse_few(self.config)

    def stages(self) -> Sequence[Stage]:
        """Data and models."""
        return [*self.data, self.learning]

    def seen(self, folder: Path) -> Answers:
        """Answers on unseen presses.

        Raises:
            OutputError: There are none in the folder.
        """
        found = read_answers(folder, self.learning, "press")
        if found is None:
            msg = f"'{folder}' holds no answers of the study's models"
            raise OutputError(msg)
        return found

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
                note="Units differ by the tolerances of the recipe.",
            ),
            curve_table(folder, self.learning, labels, seed=seed),
            compared_table(
                checked_parts(folder, self.learning, seen), labels, name="checks", title="What it rests on", seed=seed,
                note="The same presses without noise of the camera, and with four times the samples and particles.",
            ),
        )  # fmt: skip

    def curves(self, errors: Table, curve: Table, labels: Sequence[Label]) -> list[Figure]:
        """Figures of the learning curve."""
        return curve_figures(curve, errors, labels)

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
