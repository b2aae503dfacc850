"""Before contact: is something there, where, and how far; from one frame, at gaps of 0 to 25 mm."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from magicsim.dataset.recipes.entries import ClearPath, HoverPath, PathRecipe
from magicsim.errors import ConfigError
from magicsim_experiments.learn.baselines import change_features, mean_score
from magicsim_experiments.learn.samples import Chosen, EpisodeRows, Label, Samples, read_samples
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.answers import Answers
from magicsim_experiments.study.learned.data import LearnedConfig
from magicsim_experiments.study.learned.learned_study import (
    ERROR_COLUMNS,
    SAID,
    LearnedStudy,
    absolute_error,
    answer_figures,
    curve_figures,
    error_row,
    error_series,
)
from magicsim_experiments.study.plots import plot_series
from magicsim_experiments.study.protocol import Column, Figure, Matrix, Row, StudyResult, Table

THERE = Label(name="there", kind="flag")
NUMBERS = (Label(name="x", unit="mm"), Label(name="y", unit="mm"), Label(name="gap", unit="mm"))
LABELS = (THERE, *NUMBERS)
EDGES_MM = (0.0, 1.0, 3.0, 6.0, 12.0, 25.0)
"""Ends of the bins of the gap [mm]; frames with a larger gap are left out."""
ABSENT, LIKELY = 0, 0.5
"""Group of the frames without an object; probability from which the answer is that there is one."""
NOTES = (
    "The gap is the shortest distance from the object to the untouched face; x and y are those of the object's own "
    "origin, the middle of a ball or a box.",
    "The constant answer knows nothing; the nearest neighbour answers as the most alike training frame; the linear fit "
    "takes centroid and spread of the change by channel.",
    "Objects differ in size and colour, so that brightness alone does not tell the distance.",
    "The answer is 'there' from a probability of 0.5; false alarms are those on frames without an object.",
)


class RangingConfig(LearnedConfig):
    """Settings of the study."""

    kind: Literal["ranging"]


def near_frames(paths: Sequence[PathRecipe]) -> int:
    """Most frames of an episode near an object, or of nothing."""
    hover = [1 + path.approach_frames + path.retreat_frames for path in paths if isinstance(path, HoverPath)]
    return max([*hover, *(path.clear_frames for path in paths if isinstance(path, ClearPath))], default=0)


def read_approaches(folder: Path, settings: LearningSettings) -> Samples:
    """Frames of a dataset in which nothing touches."""
    return read_samples(
        folder, LABELS, _untouched, columns=("contact", "gap_mm", "object_position_mm", "object_kind"),
        long_side_px=settings.long_side_px,
    )  # fmt: skip


class Ranging(LearnedStudy):
    """The study `ranging`."""

    settings = RangingConfig
    read = read_approaches
    counted = near_frames

    def refuse(self) -> None:
        """Refuses a coat, through which nothing is seen, and a recipe without near objects or without empty frames."""
        if self.config.design.is_opaque:
            raise ConfigError(
                "study 'ranging' needs a design that is seen through: design.coat is opaque, so nothing shows before "
                "contact"
            )
        super().refuse()
        kinds = {path.kind for path in self.data[0].recipe.paths}
        if not {"hover", "clear"} <= kinds:
            msg = "recipe.paths has no hover or no clear: study 'ranging' needs frames with and without an object"
            raise ConfigError(msg)

    def conclude(self, folder: Path) -> StudyResult:
        """Detection by gap, errors of place and gap, and what they rest on."""
        seen = self.seen(folder)
        errors, units, curve, checks = self.number_tables(folder, NUMBERS)
        found = detection_table(seen, seed=self.config.seed)
        by_gap = gap_table(seen, seed=self.config.seed)
        said = {
            f"said_there_{row['gap']}".replace(" ", "_"): row["share"] for row in found.rows if row["answer"] == "model"
        }
        headline = self.headline(seen, NUMBERS)
        return StudyResult(
            headline={**headline, **said, "frames": len(seen)},
            tables=(found, errors, by_gap, units, curve, *self.beyond(folder, NUMBERS), checks),
            matrices=(presence_matrix(seen),),
            figures=(gap_figure(by_gap), *curve_figures(curve, errors, NUMBERS), *answer_figures(seen, NUMBERS)),
            facts=self.facts(seen, "frames without contact"),
            notes=NOTES,
        )


def _untouched(episode: EpisodeRows) -> Chosen:
    there = np.array([bool(kind) for kind in episode.columns["object_kind"]])
    gap = np.array([np.nan if each is None else each for each in episode.columns["gap_mm"]], float)
    gap = np.where(there, gap, np.nan)
    places = np.where(there[:, None], episode.vectors("object_position_mm", 3)[:, :2], np.nan)
    return Chosen(
        rows=~np.array(episode.columns["contact"], bool) & ~(gap > EDGES_MM[-1]) & ~(gap < 0),
        targets=np.column_stack([there.astype(float), places, gap]),
        features=change_features(episode.images, episode.untouched),
        group=np.where(there, gap_bin(np.nan_to_num(gap)), ABSENT),
    )


def gap_bin(gap_mm: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Number of the bin of each gap, from 1."""
    return np.clip(np.searchsorted(EDGES_MM, gap_mm, side="right"), 1, len(EDGES_MM) - 1).astype(np.int64)


def bin_names() -> list[str]:
    """What the bins are called, frames without an object first."""
    return ["no object", *(f"{low:g} to {high:g} mm" for low, high in pairwise(EDGES_MM))]


def detection_table(seen: Answers, *, seed: int) -> Table:
    """Share of frames of which is said that something is there, by gap and method."""
    rows: list[Row] = []
    for number, name in enumerate(bin_names()):
        part = seen.where(seen.column("group") == number)
        for method in ("model", *SAID) if len(part) else ():
            said = (part.of(method, THERE.name) > LIKELY).astype(float)
            score = mean_score(said, part.column("press"), seed=seed)
            rows.append({
                "gap": name, "answer": SAID.get(method, "model"), "share": score.value, "low": score.low,
                "high": score.high, "frames": score.frames, "presses": score.presses,
            })  # fmt: skip
    columns = (
        Column(name="gap"), Column(name="answer"), Column(name="share", title="said to be there"),
        Column(name="low", title="95 % from"), Column(name="high", title="to"), Column(name="frames"),
        Column(name="presses", title="episodes"),
    )  # fmt: skip
    return Table(name="detection", title="Is something there", columns=columns, rows=tuple(rows))


def gap_table(seen: Answers, *, seed: int) -> Table:
    """Errors by gap."""
    rows: list[Row] = []
    for label in NUMBERS:
        for number, name in enumerate(bin_names()[1:], 1):
            part = seen.where(seen.column("group") == number)
            if len(part):
                middle = (EDGES_MM[number - 1] + EDGES_MM[number]) / 2
                score = absolute_error(part, "model", label, seed=seed)
                rows.append(error_row({"gap": name, "middle_mm": middle}, label, score))
    columns = (Column(name="label"), Column(name="gap"), Column(name="unit"), *ERROR_COLUMNS)
    return Table(name="errors-by-gap", title="Errors by gap", columns=columns, rows=tuple(rows))


def gap_figure(table: Table) -> Figure:
    """Errors against the gap."""
    series = []
    for label in NUMBERS:
        rows = [row for row in table.rows if row["label"] == label.name]
        series.append(error_series(label.name, rows, "middle_mm"))
    svg = plot_series(
        series, x_title="gap [mm]", y_title="mean absolute error [mm]", name="by-gap", label="Errors against the gap"
    )
    return Figure(name="by-gap", title="Errors against the gap", svg=svg)


def presence_matrix(seen: Answers) -> Matrix:
    """Frames by gap, and what is said of them."""
    names = bin_names()
    said = seen.of("model", THERE.name) > LIKELY
    counts = np.array([[int(((seen.column("group") == k) & (said == each)).sum()) for each in (False, True)]
                       for k in range(len(names))])  # fmt: skip
    right = np.array([[k == ABSENT, k != ABSENT] for k in range(len(names))])
    return Matrix(
        name="presence", title="Is something there", truths=tuple(names), answers=("nothing", "something"),
        counts=counts, right=right,
    )  # fmt: skip
