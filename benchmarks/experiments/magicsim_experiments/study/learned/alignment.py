"""Pose of a cylinder that is pressed along the face, and what a model of one unit is worth on others."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from magicsim.dataset.recipes.recipe import Recipe
from magicsim_experiments.learn.baselines import change_features, lean_features
from magicsim_experiments.learn.fitting import Fit
from magicsim_experiments.learn.samples import Chosen, EpisodeRows, Label, Samples, read_samples
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.answers import read_answers
from magicsim_experiments.study.learned.data import LearnedConfig, further_seed
from magicsim_experiments.study.learned.learned_study import LearnedStudy, answer_figures, compared_table, curve_figures
from magicsim_experiments.study.learned.localisation import touched_frames
from magicsim_experiments.study.protocol import Stage, StudyResult
from magicsim_experiments.study.stages import DatasetStage

LABELS = (
    Label(name="p_x", unit="mm"), Label(name="p_y", unit="mm"), Label(name="p_z", unit="mm"),
    Label(name="r_z", unit="deg"),
    Label(name="f_x", unit="N"), Label(name="f_y", unit="N"), Label(name="f_z", unit="N"),
)  # fmt: skip
UNITS, PEN = "other-units", "pen"
"""Names of the further datasets."""
NOTES = (
    "P is the middle of the cylinder (x, y) and its depth (z); r_z the angle of its axis to the sensor's y. The "
    "cylinder is longer than the face, so that its place along its axis shows little.",
    "The model learns on one printed unit; the others differ by the recipe's tolerances. Half of their presses are "
    "learned from in fine-tuning, the other half is the test of both.",
    "The linear fit takes centroid, spread and lean of the change by channel.",
    "Against the protocol: fewer frames, and no average over the two fingers of a gripper.",
)


class AlignmentConfig(LearnedConfig):
    """Settings of the study."""

    kind: Literal["alignment"]
    units: Annotated[int, Field(ge=1, le=100)] = 2
    """Further printed units."""
    unit_episodes: Annotated[int, Field(ge=4, le=100_000)] = 60
    """Presses on each of them, of which half is kept for the test."""
    pen_episodes: Annotated[int, Field(ge=0, le=100_000)] = 20
    """Presses of a thinner cylinder that no model has seen, on the first unit."""
    pen_radius_mm: Annotated[float, Field(gt=0, le=50)] = 4.5
    fine_tuning: LearningSettings = LearningSettings(learning_rate=3e-4, epochs=40)
    """How the model is trained on the further units."""


def read_cylinders(folder: Path, settings: LearningSettings) -> Samples:
    """Touched frames of a dataset."""
    return read_samples(
        folder, LABELS, _touched, columns=("contact", "object_position_mm", "object_rotation", "depth_mm", "force_n"),
        long_side_px=settings.long_side_px,
    )  # fmt: skip


class Alignment(LearnedStudy):
    """The study `alignment`."""

    settings = AlignmentConfig
    read = read_cylinders
    counted = touched_frames
    knows_objects: ClassVar[bool] = True
    config: AlignmentConfig

    def __init__(self, config: AlignmentConfig) -> None:
        """Takes the settings, and lays out data of one unit, of others, and of an unseen object."""
        super().__init__(config)
        first = self.data[0].recipe
        self._units = DatasetStage(name=UNITS, recipe=self._other_units(first))
        self._pen = [DatasetStage(name=PEN, recipe=self._pens(first))] if config.pen_episodes else []
        further = (each.name for each in (self._units, *self._pen))
        self.learning = replace(self.learning, also={**self.learning.also, **dict.fromkeys(further, False)})
        fit = Fit(name="press-0", network=config.learning.networks[0], fold=0, folds=2)
        self._tuning = self.tuned(self._units, config.fine_tuning, fit)

    def stages(self) -> Sequence[Stage]:
        """All data, the models, and the fine-tuned one."""
        return [*self.data, self._units, *self._pen, self.learning, self._tuning]

    def conclude(self, folder: Path) -> StudyResult:
        """Errors on the first unit, on others without and with fine-tuning, and on an unseen object."""
        seen, seed = self.seen(folder), self.config.seed
        errors, _, curve, checks = self.number_tables(folder, LABELS)
        tuned = read_answers(folder, self._tuning, "press")
        plain = self.first_model(folder, self.learning, UNITS)
        if plain is not None and tuned is not None:
            plain = plain.where(np.isin(plain.column("press"), tuned.column("press")))
        parts = {
            "the unit that it was trained on": seen, "unknown cylinders": read_answers(folder, self.learning, "object"),
            "other units": plain, "other units, fine-tuned": tuned,
            "an unseen, thinner cylinder": self.first_model(folder, self.learning, PEN),
        }  # fmt: skip
        units = compared_table(parts, LABELS, name="units", title="Other units, an unseen object", seed=seed)
        return StudyResult(
            headline=self.headline(seen, LABELS), tables=(errors, units, curve, *self.beyond(folder, LABELS), checks),
            figures=(*curve_figures(curve, errors, LABELS), *answer_figures(seen, LABELS)),
            facts=self.facts(seen, "touched frames"), notes=NOTES,
        )  # fmt: skip

    def _other_units(self, first: Recipe) -> Recipe:
        each, episodes = self.config.unit_episodes, self.config.unit_episodes * self.config.units
        changes = {"seed": further_seed(first.seed), "episodes": episodes, "episodes_per_sensor": each}
        return first.model_copy(update=changes)

    def _pens(self, first: Recipe) -> Recipe:
        thinner = first.objects[0].model_copy(update={"radius_mm": self.config.pen_radius_mm})
        return first.model_copy(update={"objects": (thinner,), "episodes": self.config.pen_episodes})


def axis_angle_deg(rotation: np.ndarray) -> np.ndarray:
    """Angle from the sensor's y axis, about z, of an object's own y axis, in (-90, 90] degrees, shape (n,).

    Args:
        rotation: Matrices from the object's frame to the sensor's, row by row, shape (n, 9).
    """
    along_x, along_y = rotation[:, 1], rotation[:, 4]
    angle = np.degrees(np.arctan2(-along_x, along_y))
    return np.asarray(90 - np.mod(90 - angle, 180))


def _touched(episode: EpisodeRows) -> Chosen:
    rows = np.array(episode.columns["contact"], bool)
    places, rotation = episode.vectors("object_position_mm", 3)[:, :2], episode.vectors("object_rotation", 9)
    depth, forces = (np.array(episode.columns[name], float) for name in ("depth_mm", "force_n"))
    features = [each(episode.images, episode.untouched) for each in (change_features, lean_features)]
    return Chosen(
        rows=rows, targets=np.column_stack([places, depth, axis_angle_deg(rotation), forces]),
        features=np.column_stack(features), group=np.zeros(len(rows), np.int64),
    )  # fmt: skip
