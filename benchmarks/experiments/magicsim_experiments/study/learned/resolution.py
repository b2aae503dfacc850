"""How fine a texture a design tells: dots and lines of many sizes, and how often a classifier names the size."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim_experiments.learn.baselines import change_features, mean_score
from magicsim_experiments.learn.samples import Chosen, EpisodeRows, Label, Samples, read_samples
from magicsim_experiments.learn.settings import PACKAGES, LearningSettings
from magicsim_experiments.study.learned.answers import (
    Answers,
    answers_on_presses,
    beyond_rows,
    beyond_tables,
    checked_parts,
    read_answers,
)
from magicsim_experiments.study.learned.data import LearnedConfig, data_stages, learning_stage, refuse_few, share_name
from magicsim_experiments.study.learned.learned_study import SAID, error_series
from magicsim_experiments.study.plots import plot_series
from magicsim_experiments.study.protocol import Column, Figure, Matrix, Row, Stage, Study, StudyResult, Table
from magicsim_experiments.study.stages import DatasetStage, LearningStage

TOLERANCES_MM = (0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.40, 0.50)
"""Differences up to which an answer counts as right (arXiv 2505.24382) [mm]."""
ALIKE_MM = 1e-6
DEFAULT_SIZES = tuple(round(0.2 + 0.05 * k, 2) for k in range(32) if k != 1)
LEVEL = {"cells_across": 0, "edge_nodes": 0}
"""Lattice options without which cells are finer below some sizes than below others, which alone would tell these."""
Texture = Literal["dots", "lines"]
SHARE_COLUMNS = (
    Column(name="texture"), Column(name="answer"), Column(name="within_mm", title="within", unit="mm", digits=2),
    Column(name="share", title="right"), Column(name="low", title="95 % from"), Column(name="high", title="to"),
    Column(name="frames"),
)  # fmt: skip
CHECK_COLUMNS = (
    Column(name="texture"), Column(name="frames_of", title="on"),
    Column(name="error_mm", title="mean absolute error", unit="mm"), Column(name="low", title="95 % from"),
    Column(name="high", title="to"), Column(name="right", title="right within 0.1 mm"), Column(name="frames"),
)  # fmt: skip
NOTES = (
    "The size of lines is the width of the ridges, which the grooves between them have too; that of dots is their "
    "diameter, and they stand two diameters apart.",
    "An answer counts as right within a tolerance; with wide ones a constant answer is right often, so read both.",
    "Contact is solved on the lattice of the block: features finer than its spacing press as their mean does, and what "
    "shows of them comes from the skin that is fitted to the object.",
    "Against the protocol: ridges instead of grooves, one plate a size, fewer presses of each size.",
)


class ResolutionConfig(LearnedConfig):
    """Settings of the study."""

    kind: Literal["resolution"]
    textures: Annotated[tuple[Texture, ...], Field(min_length=1)] = ("dots", "lines")
    sizes_mm: Annotated[tuple[Annotated[float, Field(ge=0.1, le=3)], ...], Field(min_length=2)] = DEFAULT_SIZES
    """Sizes of the features [mm]."""
    plate_mm: Annotated[float, Field(ge=2, le=100)] = 6.0
    """Side of the pressed plates [mm]."""


class Resolution(Study):
    """The study `resolution`."""

    settings = ResolutionConfig
    config: ResolutionConfig
    packages = PACKAGES

    def __init__(self, config: ResolutionConfig) -> None:
        """Takes the settings, and lays out data and models of each texture."""
        super().__init__(config)
        self._parts = {texture: _part(config, texture) for texture in config.textures}

    def refuse(self) -> None:
        """Refuses data that cannot be learned from."""
        refuse_few(self.config)
        if len(set(self.config.sizes_mm)) < len(self.config.sizes_mm):
            raise ConfigError(f"sizes_mm = {list(self.config.sizes_mm)} is not allowed: must all differ")

    def stages(self) -> Sequence[Stage]:
        """Data and models of each texture."""
        parts: list[list[Stage]] = [[*data, learning] for data, learning in self._parts.values()]
        return [stage for part in parts for stage in part]

    def conclude(self, folder: Path) -> StudyResult:
        """Shares of right answers by tolerance, and the matrices."""
        seed, label = self.config.seed, size_label(self.config)
        rows: list[Row] = []
        checks: list[Row] = []
        figures, matrices, headline = [], [], {}
        frames: dict[str, str] = {}
        promised: list[Row] = []
        for texture, (_, learning) in self._parts.items():
            seen = answers_on_presses(folder, learning)
            own = share_rows(texture, seen, seed=seed)
            rows += own
            unknown = read_answers(folder, learning, "unit")
            parts = {"presses on known units": seen, "unknown units": unknown, **checked_parts(folder, learning, seen)}
            parts |= {
                f"{share:.0%} of the presses": read_answers(folder, learning, share_name(share))
                for share in learning.settings.curve
            }
            checks += checked_rows(texture, parts, seed=seed)
            promised += [{"texture": texture, **row} for row in beyond_rows(folder, learning, [label], seed=seed)]
            figures.append(tolerance_figure(texture, own))
            matrices.append(size_matrix(texture, seen, label))
            headline[f"{texture}_right_within_0.1_mm"] = float(right_within(seen, "model", TOLERANCES_MM[1]).mean())
            headline[f"{texture}_error_mm"] = float(seen.missed("model", "size").mean())
            frames[texture.capitalize()] = f"{len(seen)} touched frames of {len(label.choices)} sizes"
        shares = Table(
            name="shares", title="Right answers by tolerance", columns=SHARE_COLUMNS, rows=tuple(rows), shown=200
        )  # fmt: skip
        return StudyResult(
            headline=headline,
            tables=(
                shares,
                *beyond_tables(promised, Column(name="texture")),
                Table(name="checks", title="Unseen units, fewer presses", columns=CHECK_COLUMNS, rows=tuple(checks)),
            ),
            matrices=tuple(matrices),
            figures=tuple(figures),
            facts=frames | {"Networks": ", ".join(self.config.learning.networks)},
            notes=NOTES,
        )


def size_label(config: ResolutionConfig) -> Label:
    """The label: one of the sizes."""
    return Label(name="size", unit="mm", kind="choice", choices=tuple(sorted(config.sizes_mm)))


def texture_objects(config: ResolutionConfig, texture: Texture) -> list[dict[str, Any]]:
    """The plates of a recipe: every size as often as any other, turned by -90 to 90 degrees."""
    turned = {"yaw_deg": {"low": -90.0, "high": 90.0}, "size_mm": config.plate_mm, "color": [0.4, 0.4, 0.4]}
    if texture == "lines":
        return [{"kind": "lines", "width_mm": size, "spacing_mm": 2 * size, **turned} for size in config.sizes_mm]
    return [{"kind": "dots", "radius_mm": size / 2, "spacing_mm": 2 * size, **turned} for size in config.sizes_mm]


def read_textures(folder: Path, settings: LearningSettings) -> Samples:
    """Touched frames of a dataset, with the size of what is pressed; the dataset's own sizes are the choices."""
    found = read_samples(
        folder, (Label(name="size", unit="mm"),), _pressed, columns=("contact", "object_config"),
        long_side_px=settings.long_side_px,
    )  # fmt: skip
    sizes = tuple(float(each) for each in np.unique(found.targets))
    label = Label(name="size", unit="mm", kind="choice", choices=sizes)
    return replace(found, labels=(label,))


def right_within(found: Answers, method: str, tolerance_mm: float) -> Array:
    """Which answers are right within a tolerance, shape (n,), 0 or 1."""
    return (found.missed(method, "size") <= tolerance_mm + ALIKE_MM).astype(float)


def share_rows(texture: str, seen: Answers, *, seed: int) -> list[Row]:
    """Shares of right answers by method and tolerance."""
    rows: list[Row] = []
    for method in ("model", *SAID):
        for tolerance in TOLERANCES_MM:
            score = mean_score(right_within(seen, method, tolerance), seen.column("press"), seed=seed)
            rows.append({
                "texture": texture, "answer": SAID.get(method, "model"), "within_mm": tolerance, "share": score.value,
                "low": score.low, "high": score.high, "frames": score.frames,
            })  # fmt: skip
    return rows


def checked_rows(texture: str, parts: dict[str, Answers | None], *, seed: int) -> list[Row]:
    """Errors of the model on several sets of frames."""
    rows: list[Row] = []
    for name, part in parts.items():
        if part is not None and len(part):
            score = mean_score(part.missed("model", "size"), part.column("press"), seed=seed)
            right = float(right_within(part, "model", TOLERANCES_MM[1]).mean())
            rows.append({
                "texture": texture, "frames_of": name, "error_mm": score.value, "low": score.low, "high": score.high,
                "right": right, "frames": score.frames,
            })  # fmt: skip
    return rows


def tolerance_figure(texture: str, rows: Sequence[Row]) -> Figure:
    """Shares of right answers against the tolerance, beside the baselines."""
    series = []
    for answer in dict.fromkeys(str(row["answer"]) for row in rows):
        own = [row for row in rows if row["answer"] == answer]
        drawn = error_series(answer, own, "within_mm", "share")
        series.append(drawn if answer == "model" else replace(drawn, low=None, high=None))
    svg = plot_series(
        series, x_title="tolerance [mm]", y_title="share of right answers", name=f"within-{texture}",
        label=f"Right answers of {texture} against the tolerance",
    )  # fmt: skip
    return Figure(name=f"within-{texture}", title=f"{texture.capitalize()}: right answers by tolerance", svg=svg)


def size_matrix(texture: str, seen: Answers, label: Label) -> Matrix:
    """True sizes and answered ones; those within 0.1 mm count as right."""
    sizes = np.array(label.choices)
    truth, answer = (np.abs(seen.of(which, "size")[:, None] - sizes).argmin(1) for which in ("truth", "model"))
    counts = np.zeros((len(sizes), len(sizes)), np.int64)
    np.add.at(counts, (truth, answer), 1)
    names = tuple(f"{size:g}" for size in sizes)
    return Matrix(
        name=f"confusion-{texture}", title=f"Sizes of {texture} [mm]", truths=names, answers=names, counts=counts,
        right=np.abs(sizes[:, None] - sizes) <= TOLERANCES_MM[1] + ALIKE_MM, note="Within 0.1 mm counts as right.",
    )  # fmt: skip


def _part(config: ResolutionConfig, texture: Texture) -> tuple[list[DatasetStage], LearningStage]:
    design = config.design.model_copy(update={"lattice": config.design.lattice.model_copy(update=LEVEL)})
    recipe = config.recipe | {"objects": texture_objects(config, texture)}
    own = config.model_copy(update={"recipe": recipe, "design": design})
    data = [DatasetStage(name=f"{texture}-{stage.name}", recipe=stage.recipe) for stage in data_stages(own)]
    learning = learning_stage(own, data, read_textures, frames_per_episode=1, name=f"learning-{texture}")
    return data, learning


def _pressed(episode: EpisodeRows) -> Chosen:
    rows = np.array(episode.columns["contact"], bool)
    sizes = [_size(json.loads(each)) if each else np.nan for each in episode.columns["object_config"]]
    return Chosen(
        rows=rows, targets=np.array(sizes, float)[:, None],
        features=change_features(episode.images, episode.untouched), group=np.zeros(len(rows), np.int64),
    )  # fmt: skip


def _size(plate: dict[str, Any]) -> float:
    return round(float(plate["width_mm"] if plate["kind"] == "lines" else 2 * plate["radius_mm"]), 6)
