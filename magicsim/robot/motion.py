"""The way from one state to the next, as the poses at which friction has to be followed."""

import math
from dataclasses import replace

from magicsim.scenes.timeline import FrameState
from magicsim.simulation.plan import can_touch

ENTRY_STEP_MM = 0.1
"""Length of a step of an oblique way into contact [mm]."""
SLIDE_STEP_MM = 0.5
"""Length of a step within contact [mm]: a contact wider than that overlaps itself from step to step, so that its slip
can be added up; it is as long as the solver's own steps."""
MOVED = ("gap_mm", "x_mm", "y_mm", "twist_deg", "tilt_x_deg", "tilt_y_deg")


def waypoints(
    start: FrameState, end: FrameState, *, has_friction: bool, reach_mm: float, lever_mm: float = 0.0
) -> list[FrameState]:
    """States to solve in order, the last one being the end; none when nothing can touch there.

    Without friction an equilibrium does not depend on the way. With it, the way is followed from the moment of contact:
    the skin is dragged along, on an oblique way in as well.

    Args:
        start: Where the object was.
        end: Where it goes, in a straight line.
        has_friction: Whether the way matters.
        reach_mm: Distance from the vertical through the object's origin at which it can touch [mm].
        lever_mm: Height of the object over its origin, by which a tilt moves what touches [mm].
    """
    if not can_touch(end):
        return []
    if not has_friction or start.gap_mm is None or end.gap_mm is None:
        return [end]
    turn = math.radians(abs(end.twist_deg - start.twist_deg)) * reach_mm
    tilt = math.hypot(end.tilt_x_deg - start.tilt_x_deg, end.tilt_y_deg - start.tilt_y_deg)
    turn += math.radians(tilt) * lever_mm
    sideways = math.hypot(end.x_mm - start.x_mm, end.y_mm - start.y_mm) + turn
    is_inside = can_touch(start)
    if sideways == 0 and not is_inside:
        return [end]
    first = 0.0 if is_inside else start.gap_mm / (start.gap_mm - end.gap_mm)
    length = (1 - first) * math.hypot(sideways, end.gap_mm - start.gap_mm)
    count = max(1, math.ceil(length / (SLIDE_STEP_MM if is_inside else ENTRY_STEP_MM)))
    shares = [first + (1 - first) * step / count for step in range(1, count)]
    return [*(between(start, end, share) for share in shares), end]


def between(start: FrameState, end: FrameState, share: float) -> FrameState:
    """The pose at a share of the straight way between two states that have an object; lights are those of the end."""
    values = {name: (1 - share) * getattr(start, name) + share * getattr(end, name) for name in MOVED}
    return replace(end, **values)
