"""Confusion matrices and recalls as rows of a page's tables."""

from dataclasses import dataclass

from magicsim.detectors.verdict import Contact
from magicsim.frame_class import FrameClass
from magicsim.judge.score import PROXIMITY_TRUTH, DetectionScore, TaskScore
from magicsim.report.text import percent

_UNTOUCHED = (FrameClass.CLEAR, FrameClass.NEAR, FrameClass.LIGHT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One true class."""

    truth: str
    """Name of the class."""
    wanted: str
    """The verdict that is right."""
    counts: tuple[int, ...]
    """Number of frames with each verdict."""
    right: frozenset[str]
    """Verdicts that are right for the class."""
    recall: str
    """Share of right verdicts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTable:
    """Confusion matrix of one task."""

    title: str
    columns: tuple[str, ...]
    """Verdicts."""
    rows: tuple[Row, ...]
    accuracy: str
    """Balanced accuracy, or why there is none."""


def proximity_table(score: DetectionScore) -> ScoreTable:
    """Confusion matrix of the proximity verdicts."""
    truths = {str(verdict): each for each, verdict in PROXIMITY_TRUTH.items()}
    missing = [str(each) for each in PROXIMITY_TRUTH if not score.frames.get(each)]
    rows = [
        _row(score.proximity, label, truth=str(truths[label]), wanted=label, right={label})
        for label in score.proximity.row_labels
    ]
    return ScoreTable(
        title="Proximity",
        columns=score.proximity.column_labels,
        rows=tuple(rows),
        accuracy=accuracy_text(score.proximity.accuracy, ", ".join(missing)),
    )


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
    return ScoreTable(
        title="Contact",
        columns=score.contact.column_labels,
        rows=tuple(rows),
        accuracy=accuracy_text(score.contact.accuracy, ", ".join(missing)),
    )


def accuracy_text(accuracy: float | None, missing: str) -> str:
    """A balanced accuracy as a percentage, or which frames it would need."""
    return percent(accuracy) if accuracy is not None else f"not scored (no frames of {missing})"


def _row(task: TaskScore, label: str, *, truth: str, wanted: str, right: set[str]) -> Row:
    counts = task.confusion[task.row_labels.index(label)]
    return Row(truth=truth, wanted=wanted, counts=counts, right=frozenset(right), recall=percent(task.recall[label]))
