"""The answers of a study's models, read from its folder and put together over folds."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import Array, Index, Mask
from magicsim.errors import OutputError
from magicsim.judge.measures import ends
from magicsim_experiments.learn.baselines import RESAMPLES
from magicsim_experiments.learn.fitting import ANSWERS, Fit
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.study.learned.data import share_name
from magicsim_experiments.study.protocol import Column, Row, Table
from magicsim_experiments.study.stages import LearningStage


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Truth and answers of all methods on frames that no model of their fold has learned from."""

    table: pa.Table

    def __len__(self) -> int:
        """Number of frames."""
        return int(self.table.num_rows)

    def of(self, method: str, label: str) -> Array:
        """Answers of a method, or `truth`; shape (n,)."""
        return np.asarray(self.table[f"{method}.{label}"].to_numpy(), np.float64)

    def missed(self, method: str, label: str) -> Array:
        """Absolute errors of a method, NaN where there is no label; shape (n,)."""
        return np.abs(self.of(method, label) - self.of("truth", label))

    def column(self, name: str) -> Index:
        """`press`, `unit`, `group` or `train_frames`; shape (n,)."""
        return np.asarray(self.table[name].to_numpy())

    def on_presses(self, method: str, label: str) -> dict[int, float]:
        """Mean absolute error of a method on each press, by its number."""
        missed, press = self.missed(method, label), self.column("press")
        there = np.isfinite(missed)
        return {int(each): float(missed[there & (press == each)].mean()) for each in np.unique(press[there])}

    def where(self, chosen: Mask) -> "Answers":
        """Some of the frames."""
        return Answers(table=self.table.filter(pa.array(chosen)))


def read_answers(folder: Path, stage: LearningStage, prefix: str, name: str = ANSWERS) -> Answers | None:
    """Answers of all fits whose names begin so, one after the other; None where there are none.

    Args:
        prefix: Such as `press`, `unit`, `share-250` or a network's name.
    """
    paths = [stage.folder(folder, fit) / name for fit in fits_of(stage, prefix)]
    tables = [pq.read_table(path) for path in paths if path.is_file()]
    return Answers(table=pa.concat_tables(tables)) if tables else None


def answers_on_presses(folder: Path, stage: LearningStage) -> Answers:
    """Answers of all folds on presses that they have not learned from."""
    found = read_answers(folder, stage, "press")
    if found is None:
        raise OutputError(f"'{folder}' holds no answers of the study's models")
    return found


def fits_of(stage: LearningStage, prefix: str) -> list[Fit]:
    """Fits of a stage whose names are a prefix and a number."""
    return [fit for fit in stage.fits if fit.name.rpartition("-")[0] == prefix]


def checked_parts(folder: Path, stage: LearningStage, seen: Answers) -> dict[str, Answers | None]:
    """Answers on the presses that were rendered again, as they are and in each further rendering, by its name."""
    again = [name for name, same_presses in stage.also.items() if same_presses]
    further = {name: read_answers(folder, stage, "press", f"answers-{name}.parquet") for name in again}
    presses = [each.column("press") for each in further.values() if each is not None]
    if not presses:
        return {}
    return {"as they are": seen.where(np.isin(seen.column("press"), np.concatenate(presses))), **further}


LEAST_POINTS = 2
"""Points that a power law goes through."""
CurvePoint = tuple[float, Array, Index]
"""Training frames, absolute errors of frames that were answered after them (NaN without a label), and their presses."""


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


def promise(points: Sequence[CurvePoint], train_frames: Sequence[float], *, seed: int) -> list[dict[str, float]]:
    """Errors after training on more frames, as the curve's power law has them.

    Returns:
        Rows of `train_frames`, `error`, `low` and `high` (ends of the 95 % percentile interval, presses drawn again
        with replacement, the same ones at every point), and `exponent`, below 0 where the error rises. Nothing where
        fewer than two points differ in their frames, or an error is 0.
    """
    frames = np.array([count for count, _, _ in points])
    if len(np.unique(frames)) < LEAST_POINTS:
        return []
    presses = np.unique(np.concatenate([press for _, _, press in points]))
    sums, counts = np.zeros((2, len(points), len(presses)))
    for place, (_, errors, press) in enumerate(points):
        there = np.isfinite(errors)
        member = np.searchsorted(presses, press[there])
        sums[place] = np.bincount(member, errors[there], minlength=len(presses))
        counts[place] = np.bincount(member, minlength=len(presses))
    random = np.random.default_rng([seed, len(presses)])
    weights = random.multinomial(len(presses), np.full(len(presses), 1 / len(presses)), size=RESAMPLES)
    drawn_counts, drawn_sums = weights @ counts.T, weights @ sums.T
    has_errors = (drawn_sums > 0).all(1)
    if not (sums.sum(1) > 0).all() or not has_errors.any():
        return []
    factor, exponent = fit_power_law(frames, sums.sum(1) / counts.sum(1))
    factors, exponents = fit_power_law(frames, drawn_sums[has_errors] / drawn_counts[has_errors])
    found = []
    for count in train_frames:
        low, high = ends(factors * count**-exponents)
        error = float(factor * count**-exponent)
        found.append({"train_frames": count, "error": error, "low": low, "high": high, "exponent": float(exponent)})
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
    most = max((frames for frames, _ in points), default=0.0)
    rows: list[Row] = []
    for label in labels:
        curve = [(frames, found.missed("model", label.name), found.column("press")) for frames, found in points]
        promised = promise(curve, [factor * most for factor in FACTORS], seed=seed)
        rows += [
            {"label": label.name, "train_frames": each["train_frames"], "unit": label.unit, **each} for each in promised
        ]
    return rows


def beyond_tables(rows: Sequence[Row], *first: Column) -> tuple[Table, ...]:
    """The table of rows from `beyond_rows`, with columns before all others; nothing where there are none."""
    columns = (
        *first, Column(name="label"), Column(name="train_frames", title="training frames", digits=0),
        Column(name="unit"), Column(name="error", title="extrapolated mean absolute error", digits=4),
        Column(name="low", title="95 % from", digits=4), Column(name="high", title="to", digits=4),
        Column(name="exponent", title="falls with frames to the power of -"),
    )  # fmt: skip
    title = "What the learning curve promises beyond"
    return (Table(name="beyond", title=title, columns=columns, rows=tuple(rows), note=NOTE),) if rows else ()
