"""Balanced accuracy of verdicts against the truth.

Proximity is scored on Clear, Near and Light frames, never during contact. Contact is scored through the
combined verdict on every class: a Contact frame needs `Touched`; on the others only `Touched` is wrong, so
`Unknown` counts as untouched.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass

PROXIMITY_TRUTH = {
    FrameClass.CLEAR: Proximity.NORMAL,
    FrameClass.NEAR: Proximity.APPROACHING,
    FrameClass.LIGHT: Proximity.NOISE,
}
"""The right proximity verdict of each class that proximity is scored on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskScore:
    """Score of one of the two tasks."""

    accuracy: float | None
    """Mean of the recalls of the task's truths, 0..1; None unless every truth has frames."""
    recall: Mapping[str, float | None]
    """Share of right verdicts per row label; None for a row without frames."""
    confusion: tuple[tuple[int, ...], ...]
    """Number of frames, one row per true class and one column per verdict."""
    row_labels: tuple[str, ...]
    """True classes: verdicts that would be right (proximity) or frame classes (contact)."""
    column_labels: tuple[str, ...]
    """Verdicts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectionScore:
    """Scores of both tasks, with the number of frames they rest on."""

    proximity: TaskScore
    """Truths Normal, Approaching and Noise; None for the accuracy unless all three have frames."""
    contact: TaskScore
    """Truths touched (Contact) and untouched (Clear, Near and Light together)."""
    frames: Mapping[str, int]
    """Number of frames per class, and under `unscored` those without one."""


def score_verdicts(verdicts: Sequence[Verdict], classes: Sequence[FrameClass | None]) -> DetectionScore:
    """Compare verdicts with the classes of the same frames.

    Raises:
        ConfigError: The two differ in length.
    """
    if len(verdicts) != len(classes):
        raise ConfigError(f"{len(verdicts)} verdicts for {len(classes)} classes; must be one for each")
    pairs = list(zip(verdicts, classes, strict=True))
    frames = {str(each): sum(one is each for one in classes) for each in FrameClass}
    return DetectionScore(
        proximity=_score_proximity([(one, each) for one, each in pairs if each in PROXIMITY_TRUTH]),
        contact=_score_contact([(one, each) for one, each in pairs if each is not None]),
        frames=frames | {"unscored": sum(one is None for one in classes)},
    )


def proximity_right(verdict: Verdict, truth: FrameClass | None) -> bool | None:
    """Whether the proximity verdict is right; None where proximity is not scored."""
    if truth is None or truth not in PROXIMITY_TRUTH:
        return None
    return verdict.proximity is PROXIMITY_TRUTH[truth]


def contact_right(verdict: Verdict, truth: FrameClass | None) -> bool | None:
    """Whether the combined verdict is right; None where the frame is not scored."""
    if truth is None:
        return None
    return (verdict.combined is Contact.TOUCHED) == (truth is FrameClass.CONTACT)


def _score_proximity(pairs: Sequence[tuple[Verdict, FrameClass | None]]) -> TaskScore:
    columns = tuple(Proximity)
    confusion = tuple(
        tuple(sum(each is row and one.proximity is column for one, each in pairs) for column in columns)
        for row in PROXIMITY_TRUTH
    )
    truths = tuple(PROXIMITY_TRUTH.values())
    recall = {
        str(truth): _share(row[columns.index(truth)], sum(row)) for truth, row in zip(truths, confusion, strict=True)
    }
    return TaskScore(
        accuracy=_mean(list(recall.values())), recall=recall, confusion=confusion,
        row_labels=tuple(map(str, truths)), column_labels=tuple(map(str, columns)),
    )  # fmt: skip


def _score_contact(pairs: Sequence[tuple[Verdict, FrameClass | None]]) -> TaskScore:
    rows, columns = tuple(FrameClass), tuple(Contact)
    confusion = tuple(
        tuple(sum(each is row and one.combined is column for one, each in pairs) for column in columns) for row in rows
    )
    touched = columns.index(Contact.TOUCHED)
    right = {
        row: line[touched] if row is FrameClass.CONTACT else sum(line) - line[touched]
        for row, line in zip(rows, confusion, strict=True)
    }
    frames = {row: sum(line) for row, line in zip(rows, confusion, strict=True)}
    groups = ([FrameClass.CONTACT], [row for row in rows if row is not FrameClass.CONTACT])
    recalls = [_share(sum(right[row] for row in group), sum(frames[row] for row in group)) for group in groups]
    return TaskScore(
        accuracy=_mean(recalls), recall={str(row): _share(right[row], frames[row]) for row in rows},
        confusion=confusion, row_labels=tuple(map(str, rows)), column_labels=tuple(map(str, columns)),
    )  # fmt: skip


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known and len(known) == len(values) else None
