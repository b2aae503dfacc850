"""Rows of the tables of a report: scores, mistakes, what verdicts rest on, and how trustworthy the deformations are."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from magicsim.detectors.verdict import FEATURES, Contact, FeatureAtRest, Verdict
from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, NEAR_MAX_MM, NEAR_MIN_MM, FrameClass
from magicsim.judge.changed_frames import runs
from magicsim.judge.measures import UNTOUCHED
from magicsim.judge.score import PROXIMITY_TRUTH, DetectionScore, TaskScore, contact_right, proximity_right
from magicsim.judge.verdicts import Judgement
from magicsim.report.text import gap_or_depth, number, percent, quantity, scientific
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.episode import FrameTruth, SimulatedFrame


class Phase(StrEnum):
    """What happens in a frame."""

    UNTOUCHED = "untouched"
    APPROACH = "approach"
    NEAR = "near"
    TOUCH = "touch"
    PRESS = "press"
    SHEAR = "shear"
    RELEASE = "release"
    RETREAT = "retreat"
    FLASHLIGHT = "flashlight"


def tell_phases(frames: Sequence[SimulatedFrame]) -> list[Phase]:
    """Phase of every frame of a stream, in order; while nothing moves, the last motion counts."""
    phases: list[Phase] = []
    opening = sliding = False
    for place, frame in enumerate(frames):
        state = frame.truth.state
        before = frames[place - 1].truth.state if place else state
        opening = _opens(before, state, opening)
        sliding = _is_pressed(state) and _is_pressed(before) and _slides(before, state, sliding)
        phases.append(_phase(frame, opening=opening, sliding=sliding))
    return phases


def _phase(frame: SimulatedFrame, *, opening: bool, sliding: bool) -> Phase:
    gap = frame.truth.state.gap_mm
    if gap is None:
        return Phase.FLASHLIGHT if frame.truth.state.flashlight else Phase.UNTOUCHED
    if gap > NEAR_MAX_MM:
        return Phase.RETREAT if opening else Phase.APPROACH
    if gap > NEAR_MIN_MM:
        return Phase.NEAR
    if sliding:
        return Phase.SHEAR
    if opening:
        return Phase.RELEASE
    return Phase.PRESS if -gap >= CONTACT_MIN_DEPTH_MM else Phase.TOUCH


def _is_pressed(state: FrameState) -> bool:
    return state.gap_mm is not None and state.gap_mm <= NEAR_MIN_MM


def _opens(before: FrameState, now: FrameState, was: bool) -> bool:
    """Whether the object moves away; `was` where the gap stays, False where it just came."""
    if before.gap_mm is None or now.gap_mm is None:
        return False
    return was if now.gap_mm == before.gap_mm else now.gap_mm > before.gap_mm


def _slides(before: FrameState, now: FrameState, was: bool) -> bool:
    """Whether a pressed object moves along the face or turns, and not in or out."""
    if now.gap_mm != before.gap_mm:
        return False
    moved = (now.x_mm, now.y_mm, now.twist_deg) != (before.x_mm, before.y_mm, before.twist_deg)
    return moved or was


SHEET_FRAMES = 18
"""Largest number of frames on a contact sheet."""
Stretch = tuple[tuple[Phase, FrameClass | None], range]
"""Phase and class of neighbouring frames, and their places."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """What stands below one frame; None without a judgement, and where a verdict is not scored."""

    index: int
    distance: str
    force: str
    truth: str
    proximity: str | None
    proximity_right: bool | None
    contact: str | None
    contact_right: bool | None


def pick_frames(frames: Sequence[SimulatedFrame], limit: int = SHEET_FRAMES) -> list[int]:
    """Places of the frames worth showing, in order and without repeats.

    A stretch of one phase and one class gets a frame, then those in which most happens get further ones:
    equal states look the same, so what counts is the number of different states. Where there are more
    stretches than places, the first one of every class comes first, then the first of every phase, then the
    longest.
    """
    classes = [frame.truth.frame_class for frame in frames]
    scenes = _most_telling(list(runs(list(zip(tell_phases(frames), classes, strict=True)))), limit)
    variety = [len({frames[place].truth.state for place in places}) for _, places in scenes]
    counts = [1] * len(scenes)
    for _ in range(limit - len(scenes)):
        wants = [each / count if count < each else 0.0 for each, count in zip(variety, counts, strict=True)]
        if not any(wants):
            break
        counts[wants.index(max(wants))] += 1
    return [
        places[(2 * k + 1) * len(places) // (2 * count)]
        for (_, places), count in zip(scenes, counts, strict=True)
        for k in range(count)
    ]


def write_caption(frame: SimulatedFrame, verdict: Verdict | None) -> Caption:
    """What to say about a frame; `verdict` is None where nobody judged it."""
    truth = frame.truth
    return Caption(
        index=truth.index,
        distance=gap_or_depth(truth.state.gap_mm),
        force=quantity(math.hypot(*truth.force_n), "N"),
        truth=truth.label or "not scored",
        proximity=str(verdict.proximity) if verdict else None,
        proximity_right=proximity_right(verdict, truth.frame_class) if verdict else None,
        contact=str(verdict.combined) if verdict else None,
        contact_right=contact_right(verdict, truth.frame_class) if verdict else None,
    )


def _most_telling(scenes: list[Stretch], limit: int) -> list[Stretch]:
    """At most `limit` of the stretches, in order."""
    if len(scenes) <= limit:
        return scenes
    numbers = range(len(scenes))
    first_of_class = {scenes[k][0][1]: k for k in reversed(numbers) if scenes[k][0][1]}
    first_of_phase = {scenes[k][0][0]: k for k in reversed(numbers)}
    longest = sorted(numbers, key=lambda k: -len(scenes[k][1]))
    ranked = dict.fromkeys([*first_of_class.values(), *first_of_phase.values(), *longest])
    return [scenes[k] for k in sorted(list(ranked)[:limit])]


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
    if not any(score.frames.get(each) for each in UNTOUCHED):
        missing.append(" or ".join(UNTOUCHED))
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
