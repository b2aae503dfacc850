"""What studies have in common that learn numbers from one dataset.

Tables and figures of answers that are numbers: mean absolute errors by label, beside what simple answers give.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import ClassVar

import numpy as np

from magicsim.dataset.recipes.entries import PathRecipe
from magicsim_experiments.learn.baselines import Score, mean_score
from magicsim_experiments.learn.fitting import ANSWERS, Fit, Read
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.learn.settings import PACKAGES, LearningSettings
from magicsim_experiments.study.learned.answers import (
    Answers,
    answers_on_presses,
    beyond_rows,
    beyond_tables,
    checked_parts,
    curve_answers,
    read_answers,
)
from magicsim_experiments.study.learned.data import (
    LearnedConfig,
    count_objects,
    data_stages,
    learning_stage,
    refuse_few,
)
from magicsim_experiments.study.plots import Series, plot_answers, plot_intervals, plot_series
from magicsim_experiments.study.protocol import Cell, Column, Figure, Row, Stage, Study, StudyConfig, Table, column_of
from magicsim_experiments.study.stages import DatasetStage, LearningStage

ERROR_COLUMNS = (
    Column(name="error", title="mean absolute error", digits=4),
    Column(name="sd", title="standard deviation", digits=4),
    Column(name="low", title="95 % from", digits=4), Column(name="high", title="to", digits=4),
    Column(name="frames"), Column(name="presses"),
)  # fmt: skip
SAID = {
    "constant": "constant answer", "neighbour": "nearest neighbour", "linear": "linear fit of geometric features",
}  # fmt: skip


LEAST_UNITS = 5
"""Fewer printed units say nothing of others: intervals then draw presses of the same ones."""


def absolute_error(found: Answers, method: str, label: Label, *, seed: int, drawn: str = "press") -> Score:
    """Mean absolute error of a method, over frames that have the label.

    Args:
        drawn: What the interval draws again: `press`, or `unit` for what is said of printed units that nobody saw,
            where there are five at least.
    """
    units = found.column("unit")
    groups = units if drawn == "unit" and len(np.unique(units)) >= LEAST_UNITS else found.column("press")
    score = mean_score(found.missed(method, label.name), groups, seed=seed)
    return replace(score, presses=len(found.on_presses(method, label.name)))


def error_row(first: Mapping[str, Cell], label: Label, score: Score) -> Row:
    """A row of a table of errors."""
    return {
        **first, "label": label.name, "unit": label.unit, "error": score.value, "sd": score.sd, "low": score.low,
        "high": score.high, "frames": score.frames, "presses": score.presses,
    }  # fmt: skip


def methods_table(folder: Path, stage: LearningStage, labels: Sequence[Label], *, seed: int) -> Table:
    """Errors of the networks on unseen presses, beside the baselines."""
    first, *others = stage.settings.networks
    seen = answers_on_presses(folder, stage)
    answered: list[tuple[str, Answers | None, str]] = [(first, seen, "model")]
    answered += [(other, read_answers(folder, stage, other), "model") for other in others]
    answered += [(said, seen, method) for method, said in SAID.items()]
    rows = [
        error_row({"answer": name}, label, absolute_error(found, method, label, seed=seed))
        for label in labels
        for name, found, method in answered
        if found is not None
    ]
    columns = (Column(name="label"), Column(name="answer"), Column(name="unit"), *ERROR_COLUMNS)
    return Table(name="errors", title="Errors on unseen presses", columns=columns, rows=tuple(rows))


def compared_table(
    parts: Mapping[str, Answers | None], labels: Sequence[Label], *, name: str, title: str, seed: int, note: str = "",
    unseen: str = "",
) -> Table:  # fmt: skip
    """Errors of the model on several sets of frames, by label.

    Args:
        parts: Sets of frames by what they are called; those that are None are left out.
        unseen: The set of printed units that no model saw: its interval draws units, where there are enough.
    """
    rows = [
        error_row(
            {"frames_of": part}, label,
            absolute_error(found, "model", label, seed=seed, drawn="unit" if part == unseen else "press"),
        )
        for label in labels
        for part, found in parts.items()
        if found is not None and len(found)
    ]  # fmt: skip
    columns = (Column(name="label"), Column(name="frames_of", title="on"), Column(name="unit"), *ERROR_COLUMNS)
    return Table(name=name, title=title, columns=columns, rows=tuple(rows), note=note)


def pairs_table(parts: Mapping[str, Answers], *, seed: int) -> Table:
    """By which share errors on further sets of frames are larger than on the first, on presses of the same numbers.

    Intervals then hold what the sets differ in alone; one around 0 says how large a difference could be missed. Where
    labels differ in size, as forces do on a softer block, the constant's row says by how much.
    """
    (itself, first), *others = parts.items()
    labels = [name.removeprefix("truth.") for name in first.table.column_names if name.startswith("truth.")]
    rows = []
    for label, method, (name, further) in product(labels, ("model", "linear", "constant"), others):
        own, other = (each.on_presses(method, label) for each in (first, further))
        more = {press: other[press] - own[press] for press in own.keys() & other.keys()}
        shares = np.array(list(more.values())) / (np.mean([own[press] for press in more]) or np.nan)
        score = mean_score(shares, np.array(list(more)), seed=seed)
        rows.append(error_row({"on": name, "answer": SAID.get(method, method)}, Label(name=label, unit="share"), score))
    columns = (Column(name="label"), Column(name="answer"), Column(name="on"), *ERROR_COLUMNS)
    title = f"Errors beyond those of {itself} on the same presses, in shares of them"
    return Table(name="pairs", title=title, columns=columns, rows=tuple(rows))


def pairs_figures(pairs: Table) -> list[Figure]:
    """Such a table as drawings, one a method."""
    figures = []
    for place, said in enumerate(dict.fromkeys(row["answer"] for row in pairs.rows)):
        rows = {f"{row['on']}, {row['label']}": row for row in pairs.rows if row["answer"] == said}
        name, title = f"{pairs.name}-{place}", f"{pairs.title}: {said}"
        figures.append(Figure(name=name, title=title, svg=plot_intervals(rows, name=name, label=title)))
    return figures


def curve_table(folder: Path, stage: LearningStage, labels: Sequence[Label], *, seed: int) -> Table:
    """Errors against the number of training frames."""
    rows = [
        error_row({"train_frames": frames}, label, absolute_error(found, "model", label, seed=seed))
        for frames, found in curve_answers(folder, stage)
        for label in labels
    ]
    columns = (
        Column(name="label"), Column(name="train_frames", title="training frames", digits=0), Column(name="unit"),
        *ERROR_COLUMNS,
    )  # fmt: skip
    rows.sort(key=lambda row: [label.name for label in labels].index(str(row["label"])))
    return Table(name="curve", title="Learning curve", columns=columns, rows=tuple(rows))


def curve_figures(curve: Table, errors: Table, labels: Sequence[Label]) -> list[Figure]:
    """The learning curve of each label, with its baselines as levels."""
    figures = []
    for label in labels:
        rows = [row for row in curve.rows if row["label"] == label.name]
        if not rows:
            continue
        own = [row for row in errors.rows if row["label"] == label.name]
        levels = dict(zip((str(row["answer"]) for row in own), column_of(own, "error"), strict=True))
        series = [
            error_series("model", rows, "train_frames"),
            *(Series(name=name, x=[], y=[levels[name]], is_level=True) for name in SAID.values() if name in levels),
        ]  # fmt: skip
        svg = plot_series(
            series, x_title="training frames", y_title=f"mean absolute error [{label.unit}]",
            name=f"curve-{label.name.replace('_', '-')}", label=f"Error of {label.name} against training frames",
            log_x=True,
        )  # fmt: skip
        figures.append(Figure(name=f"curve-{label.name}", title=f"Learning curve of {label.name}", svg=svg))
    return figures


def answer_figures(found: Answers, labels: Sequence[Label]) -> list[Figure]:
    """The model's answers against the truth, a figure a label."""
    figures = []
    for label in labels:
        truth, answer = found.of("truth", label.name), found.of("model", label.name)
        there = np.isfinite(truth)
        if there.any():
            name = f"answers-{label.name.replace('_', '-')}"
            svg = plot_answers(
                truth[there], answer[there], unit=label.unit, name=name, label=f"Answers of {label.name} against truth"
            )
            figures.append(Figure(name=name, title=f"Answers of {label.name}", svg=svg))
    return figures


def error_series(name: str, rows: Sequence[Row], x: str, y: str = "error") -> Series:
    """A curve of errors with their intervals, from rows of a table."""
    values = {key: column_of(rows, key) for key in (x, y, "low", "high")}
    return Series(name=name, x=values[x], y=values[y], low=values["low"], high=values["high"])


class LearnedStudy(Study):
    """A study of one dataset and its models; a kind says what is learned, and what is made of the answers."""

    settings: ClassVar[type[StudyConfig]] = LearnedConfig
    config: LearnedConfig
    packages = PACKAGES
    read: ClassVar[Read]
    """Makes samples of a dataset; importable by name."""
    counted: ClassVar[Callable[[Sequence[PathRecipe]], int]]
    """Most frames of an episode on such paths that count."""
    needs_masks: ClassVar[bool] = False
    """Whether contact masks are needed."""
    knows_objects: ClassVar[bool] = False
    """Whether models are also tested on objects that they have not learned from."""

    def __init__(self, config: LearnedConfig) -> None:
        """Takes the settings, and lays out data and models."""
        super().__init__(config)
        self.data = data_stages(config, masks=self.needs_masks)
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

    def tuned(self, data: DatasetStage, settings: LearningSettings, *fits: Fit) -> LearningStage:
        """The first model, trained further on other data."""
        frames, own = data.recipe.episodes * type(self).counted(data.recipe.paths), self.learning.settings
        alike = settings.model_copy(update={"long_side_px": own.long_side_px, "input": own.input})
        return replace(
            self.learning, name="fine-tuning", dataset=data.name, recipe=data.recipe, settings=alike, frames=frames,
            also={}, start=(self.learning.name, self.learning.fits[0].name), fits=fits,
        )  # fmt: skip

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
                parts, labels, name="units", title="Unseen units", seed=seed, unseen="unknown units",
                note="Units differ by the tolerances of the recipe, and by their room where it draws one. Intervals of "
                f"unknown ones draw units again, from {LEAST_UNITS} on; of fewer, presses: they hold no other unit.",
            ),
            curve_table(folder, self.learning, labels, seed=seed),
            compared_table(
                checked_parts(folder, self.learning, seen), labels, name="checks", title="What it rests on", seed=seed,
                note="The same presses without noise of the camera, and with four times the samples and particles or, "
                "of the fast tier, rendered truly.",
            ),
        )  # fmt: skip

    def facts(self, seen: Answers, what: str) -> dict[str, str]:
        """What the result was made of, in words."""
        presses, units = (len(np.unique(seen.column(name))) for name in ("press", "unit"))
        recipe = self.data[0].recipe
        camera = recipe.rig.camera
        return {
            "Frames": f"{len(seen)} {what} of {presses} episodes",
            "Printed units": str(units),
            "Frames rendered at": f"{camera.columns} x {camera.rows} pixels, render.tier = {recipe.render.tier}",
            "Forces": f"contact.quality = {recipe.contact.quality}",
            "Networks": ", ".join(self.config.learning.networks),
        }
