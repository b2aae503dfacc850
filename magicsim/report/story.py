"""The part of the story that each frame belongs to, from where the object and the light are."""

from collections.abc import Sequence
from enum import StrEnum

from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, NEAR_MAX_MM, NEAR_MIN_MM
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
