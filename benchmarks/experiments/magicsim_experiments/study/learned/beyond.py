"""What the learning curve of a study promises of more frames than were made: extrapolated, and said to be."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from magicsim_experiments.learn.extrapolation import CurvePoint, promise
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.study.learned.answers import Answers, read_answers
from magicsim_experiments.study.learned.data import share_name
from magicsim_experiments.study.result import Column, Row, Table
from magicsim_experiments.study.stages.learning_stage import LearningStage

FACTORS = (2.0, 5.0, 10.0)
"""Frames to learn from, in units of those of the study."""
NOTE = (
    "Extrapolated, not measured: a power law through the points of the learning curve. It has no floor, so that it is "
    "too low where other things than the number of frames limit the error. Intervals draw presses again; they hold "
    "neither another training nor a curve that bends."
)


def curve_answers(folder: Path, stage: LearningStage) -> list[tuple[float, Answers]]:
    """Points of the learning curve: mean number of training frames, and the answers on unseen presses, fewest first."""
    found = []
    for prefix in [*(share_name(share) for share in sorted(stage.settings.curve)), "press"]:
        answers = read_answers(folder, stage, prefix)
        if answers is not None:
            found.append((float(np.mean(np.unique(answers.column("train_frames")))), answers))
    return found


def beyond_rows(folder: Path, stage: LearningStage, labels: Sequence[Label], *, seed: int) -> list[Row]:
    """Extrapolated errors by label; none where the curve has one point alone."""
    points = curve_answers(folder, stage)
    rows: list[Row] = []
    for label in labels:
        curve = [
            CurvePoint(
                train_frames=frames, errors=np.abs(found.of("model", label.name) - found.of("truth", label.name)),
                press=found.column("press"),
            )
            for frames, found in points
        ]  # fmt: skip
        most = max((frames for frames, _ in points), default=0.0)
        rows += [
            {
                "label": label.name, "train_frames": each.train_frames, "unit": label.unit, "error": each.value,
                "low": each.low, "high": each.high, "exponent": each.exponent,
            }
            for each in promise(curve, [factor * most for factor in FACTORS], seed=seed)
        ]  # fmt: skip
    return rows


def beyond_tables(rows: Sequence[Row], *first: Column) -> tuple[Table, ...]:
    """The table of extrapolated errors, or nothing where there are none.

    Args:
        rows: From `beyond_rows`.
        *first: Columns before all others.
    """
    columns = (
        *first, Column(name="label"), Column(name="train_frames", title="training frames", digits=0),
        Column(name="unit"), Column(name="error", title="extrapolated mean absolute error", digits=4),
        Column(name="low", title="95 % from", digits=4), Column(name="high", title="to", digits=4),
        Column(name="exponent", title="falls with frames to the power of -"),
    )  # fmt: skip
    title = "What the learning curve promises beyond"
    return (Table(name="beyond", title=title, columns=columns, rows=tuple(rows), note=NOTE),) if rows else ()
