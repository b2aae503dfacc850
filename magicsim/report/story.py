"""The story of an episode: the phase of each frame, and the frames of a contact sheet with what stands below them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, NEAR_MAX_MM, NEAR_MIN_MM, FrameClass
from magicsim.judge.score import contact_right, proximity_right
from magicsim.report.text import gap_or_depth, quantity
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.episode import SimulatedFrame

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class Run(Generic[Value]):
    """Neighbouring places that hold the same value."""

    start: int
    """First place."""
    stop: int
    """Place after the last one."""
    value: Value
    """What they hold."""

    @property
    def length(self) -> int:
        """Number of places."""
        return self.stop - self.start


def runs(values: Sequence[Value]) -> Iterator[Run[Value]]:
    """The longest stretches of equal neighbours, in order; together they cover every place once."""
    start = 0
    for place in range(1, len(values) + 1):
        if place == len(values) or values[place] != values[start]:
            yield Run(start=start, stop=place, value=values[start])
            start = place


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
Scene = Run[tuple[Phase, FrameClass | None]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """What stands below one frame."""

    index: int
    """Place of the frame in the stream."""
    phase: str
    """Part of the story."""
    distance: str
    """Gap or depth."""
    force: str
    """Magnitude of the contact force."""
    truth: str
    """Class, or that the frame is not scored."""
    proximity: str | None
    """Proximity verdict; None without a judgement."""
    proximity_right: bool | None
    """Whether it is right; None where it is not scored."""
    contact: str | None
    """Combined verdict; None without a judgement."""
    contact_right: bool | None
    """Whether it is right; None where it is not scored."""


def pick_frames(frames: Sequence[SimulatedFrame], limit: int = SHEET_FRAMES) -> list[int]:
    """Places of the frames worth showing, in order and without repeats.

    A stretch of one phase and one class gets a frame, then those in which most happens get further ones:
    equal states look the same, so what counts is the number of different states. Where there are more
    stretches than places, the first one of every class comes first, then the first of every phase, then the
    longest.
    """
    classes = [frame.truth.frame_class for frame in frames]
    scenes = _most_telling(list(runs(list(zip(tell_phases(frames), classes, strict=True)))), limit)
    variety = [len({frame.truth.state for frame in frames[each.start : each.stop]}) for each in scenes]
    counts = [1] * len(scenes)
    for _ in range(limit - len(scenes)):
        wants = [each / count if count < each else 0.0 for each, count in zip(variety, counts, strict=True)]
        if not any(wants):
            break
        counts[wants.index(max(wants))] += 1
    return [
        each.start + (2 * k + 1) * each.length // (2 * count)
        for each, count in zip(scenes, counts, strict=True)
        for k in range(count)
    ]


def write_caption(frame: SimulatedFrame, phase: Phase, verdict: Verdict | None) -> Caption:
    """What to say about a frame; `verdict` is None where nobody judged it."""
    truth = frame.truth
    return Caption(
        index=truth.index,
        phase=str(phase),
        distance=gap_or_depth(truth.state.gap_mm),
        force=quantity(math.hypot(*truth.force_n), "N"),
        truth=str(truth.frame_class) if truth.frame_class else "not scored",
        proximity=str(verdict.proximity) if verdict else None,
        proximity_right=proximity_right(verdict, truth.frame_class) if verdict else None,
        contact=str(verdict.combined) if verdict else None,
        contact_right=contact_right(verdict, truth.frame_class) if verdict else None,
    )


def _most_telling(scenes: list[Scene], limit: int) -> list[Scene]:
    """At most `limit` of the stretches, in order."""
    if len(scenes) <= limit:
        return scenes
    places = range(len(scenes))
    first_of_class = {scenes[k].value[1]: k for k in reversed(places) if scenes[k].value[1]}
    first_of_phase = {scenes[k].value[0]: k for k in reversed(places)}
    longest = sorted(places, key=lambda k: -scenes[k].length)
    ranked = dict.fromkeys([*first_of_class.values(), *first_of_phase.values(), *longest])
    return [scenes[k] for k in sorted(list(ranked)[:limit])]
