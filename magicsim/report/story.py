"""The story of an episode: the phase of each frame, and the frames of a contact sheet with what stands below them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, NEAR_MAX_MM, NEAR_MIN_MM, FrameClass
from magicsim.judge.changed_frames import runs
from magicsim.judge.score import contact_right, proximity_right
from magicsim.report.text import gap_or_depth, quantity
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.episode import SimulatedFrame


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
    phase: str
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


def write_caption(frame: SimulatedFrame, phase: Phase, verdict: Verdict | None) -> Caption:
    """What to say about a frame; `verdict` is None where nobody judged it."""
    truth = frame.truth
    return Caption(
        index=truth.index,
        phase=str(phase),
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
