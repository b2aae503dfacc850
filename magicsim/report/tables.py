"""Rows of the tables of a report: scores, mistakes, what verdicts rest on, and how trustworthy the deformations are."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.detectors.verdict import FEATURES, Contact, FeatureAtRest, Verdict
from magicsim.frame_class import FrameClass
from magicsim.judge.changed_frames import runs
from magicsim.judge.score import PROXIMITY_TRUTH, DetectionScore, TaskScore, contact_right, proximity_right
from magicsim.judge.verdicts import Judgement
from magicsim.report.story import tell_phases
from magicsim.report.text import number, percent, quantity, scientific
from magicsim.simulation.episode import FrameTruth, SimulatedFrame

_UNTOUCHED = (FrameClass.CLEAR, FrameClass.NEAR, FrameClass.LIGHT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One true class: the verdict that is right, frames with each verdict, and the share of right ones."""

    truth: str
    wanted: str
    counts: tuple[int, ...]
    right: frozenset[str]
    recall: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTable:
    """Confusion matrix of one task."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    accuracy: str
    """Balanced accuracy, or why there is none."""


def proximity_table(score: DetectionScore) -> ScoreTable:
    """Confusion matrix of the proximity verdicts."""
    truths = {str(verdict): each for each, verdict in PROXIMITY_TRUTH.items()}
    missing = [str(each) for each in PROXIMITY_TRUTH if not score.frames.get(each)]
    task = score.proximity
    rows = [_row(task, each, truth=str(truths[each]), wanted=each, right={each}) for each in task.row_labels]
    return _table("Proximity", task, rows, missing)


def contact_table(score: DetectionScore) -> ScoreTable:
    """Confusion matrix of the combined contact verdicts."""
    touched = {str(Contact.TOUCHED)}
    missing = [] if score.frames.get(FrameClass.CONTACT) else [str(FrameClass.CONTACT)]
    if not any(score.frames.get(each) for each in _UNTOUCHED):
        missing.append(" or ".join(_UNTOUCHED))
    rows = []
    for label in score.contact.row_labels:
        right = touched if label == FrameClass.CONTACT else set(score.contact.column_labels) - touched
        wanted = str(Contact.TOUCHED) if right is touched else f"not {Contact.TOUCHED}"
        rows.append(_row(score.contact, label, truth=label, wanted=wanted, right=right))
    return _table("Contact", score.contact, rows, missing)


def _table(title: str, task: TaskScore, rows: Sequence[Row], missing: Sequence[str]) -> ScoreTable:
    """A table with its balanced accuracy as a percentage, or which frames it would need."""
    needed = f"not scored (no frames of {', '.join(missing)})"
    accuracy = percent(task.accuracy) if task.accuracy is not None else needed
    return ScoreTable(title=title, columns=task.column_labels, rows=tuple(rows), accuracy=accuracy)


def _row(task: TaskScore, label: str, *, truth: str, wanted: str, right: set[str]) -> Row:
    counts = task.confusion[task.row_labels.index(label)]
    return Row(truth=truth, wanted=wanted, counts=counts, right=frozenset(right), recall=percent(task.recall[label]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Mistake:
    """Neighbouring frames of one class with the same wrong verdict, by their places in the stream."""

    first: int
    last: int
    truth: str
    verdict: str


def list_mistakes(frames: Sequence[SimulatedFrame], verdicts: Sequence[Verdict]) -> list[Mistake]:
    """All wrong verdicts, proximity first, with neighbouring equal ones taken together."""
    classes = [frame.truth.frame_class for frame in frames]
    pairs = list(zip(verdicts, classes, strict=True))
    near = [(each, one.proximity) if proximity_right(one, each) is False else None for one, each in pairs]
    touch = [(each, one.combined) if contact_right(one, each) is False else None for one, each in pairs]
    found = [each for wrong in (near, touch) for each in runs(wrong)]
    index = [frame.truth.index for frame in frames]
    return [
        Mistake(first=index[places[0]], last=index[places[-1]], truth=str(pair[0]), verdict=str(pair[1]))
        for pair, places in found
        if pair is not None
    ]


THRESHOLDS = {"entropy": "tau_e", "correlation": "tau_c", "similarity": "tau_g"}
"""Threshold of each measure of a verdict."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestRow:
    """One measure."""

    name: str
    at_rest: str
    threshold: str
    parts: tuple[str, ...]
    """In each part of the story: median and d'."""


def rest_rows(frames: Sequence[SimulatedFrame], judgement: Judgement) -> tuple[list[str], list[RestRow]]:
    """Parts of the story that have frames, and one row a measure; none where nothing was said of the rest."""
    phases = tell_phases(frames)
    parts = list(dict.fromkeys(phases))
    rows = []
    for key, name in FEATURES.items():
        rest = judgement.at_rest.get(key)
        if rest is None:
            continue
        values = np.array([getattr(each, key) for each in judgement.verdicts])
        medians = [float(np.median(values[[one == part for one in phases]])) for part in parts]
        rows.append(
            RestRow(
                name=name, at_rest=f"{rest.mean:.3f} ± {rest.sd:.2g}",
                threshold=_with_distance(judgement.thresholds[THRESHOLDS[key]], rest),
                parts=tuple(_with_distance(each, rest) for each in medians),
            )
        )  # fmt: skip
    return [str(part) for part in parts], rows


def _with_distance(value: float, rest: FeatureAtRest) -> str:
    return f"{number(value, 3)} ({rest.distance(value):+.0f})"


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveRow:
    """The worst value of one figure, and the place in the stream of the frame that has it."""

    name: str
    value: str
    index: int


def solve_rows(frames: Sequence[SimulatedFrame]) -> list[SolveRow]:
    """Worst figures over the frames with contact or with a solve; none where there was neither."""
    solved = [frame for frame in frames if frame.truth.contact or frame.truth.solve.iterations]
    figures: dict[str, tuple[Callable[[FrameTruth], float], Callable[[float], str]]] = {
        "most iterations of a frame": (lambda one: one.solve.iterations, lambda value: number(value, 0)),
        "smallest Jacobian": (lambda one: -one.solve.min_jacobian, lambda value: number(-value, 3)),
        "deepest penetration": (lambda one: one.solve.max_penetration_mm, lambda value: f"{scientific(value)}\u00a0mm"),
        "worst force balance": (lambda one: one.solve.force_balance, scientific),
        "largest force": (lambda one: math.hypot(*one.force_n), lambda value: quantity(value, "N")),
        "largest contact area": (lambda one: one.contact_area_mm2, lambda value: quantity(value, "mm\u00b2", 1)),
    }
    rows = []
    for name, (measure, write) in figures.items() if solved else ():
        worst = max((frame.truth for frame in solved), key=lambda truth: _badness(measure(truth)))
        rows.append(SolveRow(name=name, value=write(measure(worst)), index=worst.index))
    return rows


def _badness(value: float) -> float:
    """The value; one that is not a number is the worst."""
    return math.inf if math.isnan(value) else value
