"""Balanced accuracy of verdicts against the truth.

Proximity is scored on Clear, Near and Light frames, never during contact. Contact is scored through the
combined verdict on every class: a Contact frame needs `Touched`; on the others only `Touched` is wrong, so
`Unknown` counts as untouched.
"""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
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
    frames, touched = {str(each): sum(one is each for one in classes) for each in FrameClass}, {Contact.TOUCHED}
    return DetectionScore(
        proximity=_task(
            Counter((each, one.proximity) for one, each in pairs),
            {row: {verdict} for row, verdict in PROXIMITY_TRUTH.items()},
            labels={row: str(verdict) for row, verdict in PROXIMITY_TRUTH.items()},
            columns=tuple(Proximity),
            groups=[[row] for row in PROXIMITY_TRUTH],
        ),
        contact=_task(
            Counter((each, one.combined) for one, each in pairs),
            {row: touched if row is FrameClass.CONTACT else set(Contact) - touched for row in FrameClass},
            labels={row: str(row) for row in FrameClass},
            columns=tuple(Contact),
            groups=[[FrameClass.CONTACT], [row for row in FrameClass if row is not FrameClass.CONTACT]],
        ),
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


def _task(
    count: Mapping[tuple[FrameClass | None, str], int],
    right: Mapping[FrameClass, Collection[str]],
    *,
    labels: Mapping[FrameClass, str],
    columns: tuple[str, ...],
    groups: Sequence[Sequence[FrameClass]],
) -> TaskScore:
    """Score of counted classes and verdicts; `right` verdicts of each class, and which classes weigh as one truth."""
    frames = {row: sum(count[row, column] for column in columns) for row in right}
    hits = {row: sum(count[row, column] for column in verdicts) for row, verdicts in right.items()}
    recalls = [_share(sum(hits[row] for row in group), sum(frames[row] for row in group)) for group in groups]
    known = [recall for recall in recalls if recall is not None]
    return TaskScore(
        accuracy=sum(known) / len(known) if len(known) == len(recalls) else None,
        recall={labels[row]: _share(hits[row], frames[row]) for row in right},
        confusion=tuple(tuple(count[row, column] for column in columns) for row in right),
        row_labels=tuple(labels.values()), column_labels=tuple(map(str, columns)),
    )  # fmt: skip


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
