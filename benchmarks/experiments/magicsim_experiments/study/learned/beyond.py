"""What the learning curve of a study promises of more frames than were made: extrapolated, and said to be."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.sampling.bootstrap import ends
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.learn.scores import RESAMPLES
from magicsim_experiments.study.learned.answers import Answers, read_answers
from magicsim_experiments.study.learned.data import share_name
from magicsim_experiments.study.result import Column, Row, Table
from magicsim_experiments.study.stages.learning_stage import LearningStage

LEAST_POINTS = 2
"""Points that a power law goes through."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoint:
    """Errors of frames that were answered after training on so many."""

    train_frames: float
    errors: Array
    """Absolute errors, shape (n,); NaN where there is no label."""
    press: Index
    """Press of each, shape (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Promise:
    """An extrapolated error, with what it may be for other presses."""

    train_frames: float
    value: float
    low: float
    """Ends of the 95 % percentile interval, presses drawn again with replacement, the same ones at every point."""
    high: float
    exponent: float
    """Power with which the error falls; below 0 where it rises."""


def fit_power_law(train_frames: Array, errors: Array) -> tuple[Array, Array]:
    """Factor and exponent of `error = factor * frames ** -exponent`, least squares of the logarithms.

    Args:
        train_frames: Shape (points,), two of them different at least.
        errors: Shape (..., points), above 0.

    Returns:
        Factors and exponents, shape (...).
    """
    x, y = np.log(train_frames), np.log(errors)
    middle = x - x.mean()
    exponent = -(y * middle).sum(-1) / (middle**2).sum()
    return np.exp(y.mean(-1) + exponent * x.mean()), exponent


def promise(points: Sequence[CurvePoint], train_frames: Sequence[float], *, seed: int) -> list[Promise]:
    """Errors after training on more frames, as the curve's power law has them.

    Returns:
        Nothing where fewer than two points differ in their frames, or an error is 0.
    """
    frames = np.array([point.train_frames for point in points])
    if len(np.unique(frames)) < LEAST_POINTS:
        return []
    presses = np.unique(np.concatenate([point.press for point in points]))
    sums, counts = np.zeros((2, len(points), len(presses)))
    for place, point in enumerate(points):
        there = np.isfinite(point.errors)
        member = np.searchsorted(presses, point.press[there])
        sums[place] = np.bincount(member, point.errors[there], minlength=len(presses))
        counts[place] = np.bincount(member, minlength=len(presses))
    random = np.random.default_rng([seed, len(presses)])
    weights = random.multinomial(len(presses), np.full(len(presses), 1 / len(presses)), size=RESAMPLES)
    drawn_counts, drawn_sums = weights @ counts.T, weights @ sums.T
    has_errors = (drawn_sums > 0).all(1)
    if not (sums.sum(1) > 0).all() or not has_errors.any():
        return []
    drawn = drawn_sums[has_errors] / drawn_counts[has_errors]
    factor, exponent = fit_power_law(frames, sums.sum(1) / counts.sum(1))
    factors, exponents = fit_power_law(frames, drawn)
    found = []
    for count in train_frames:
        low, high = ends(factors * count**-exponents)
        found.append(
            Promise(
                train_frames=count, value=float(factor * count**-exponent), low=low, high=high, exponent=float(exponent)
            )
        )
    return found


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
