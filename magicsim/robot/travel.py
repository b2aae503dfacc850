"""Where an object's straight way ends in equilibrium, and how far the skin slid over it meanwhile."""

import math
from dataclasses import replace

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import contact_face, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor

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
    if not end.can_touch:
        return []
    if not has_friction or start.gap_mm is None or end.gap_mm is None:
        return [end]
    turn = math.radians(abs(end.twist_deg - start.twist_deg)) * reach_mm
    tilt = math.hypot(end.tilt_x_deg - start.tilt_x_deg, end.tilt_y_deg - start.tilt_y_deg)
    turn += math.radians(tilt) * lever_mm
    sideways = math.hypot(end.x_mm - start.x_mm, end.y_mm - start.y_mm) + turn
    is_inside = start.can_touch
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


def slip_share(deformation: Deformation, area_mm2: Array) -> float:
    """Share of the normal force that presses on sliding points, 0 without contact, 1 in full slip.

    Args:
        deformation: An equilibrium.
        area_mm2: Rest area of each contact point, shape (points,) [mm2].
    """
    if deformation.is_rest:
        return 0.0
    force = area_mm2 * deformation.contact_pressure_mpa
    total = float(force.sum())
    return float(force[deformation.is_slipping].sum()) / total if total > 0 else 0.0


def slip_mm(before: Deformation, after: Deformation, area_mm2: Array) -> float:
    """How far the skin slid over the object between two equilibria, the mean over the contact [mm].

    A sticking point keeps its anchor in the object's frame and a sliding one drags it along (see
    `magicsim.deform.contact.friction`), so the anchors' way is the way of sliding. Points count by their normal force
    after.

    Args:
        before: The equilibrium before, of the same lattice.
        after: The one that followed from it.
        area_mm2: Rest area of each contact point, shape (points,) [mm2].
    """
    if before.is_rest or after.is_rest:
        return 0.0
    touching = (before.contact_pressure_mpa > 0) & (after.contact_pressure_mpa > 0)
    weight = (area_mm2 * after.contact_pressure_mpa)[touching]
    way = np.linalg.norm((after.anchors_mm - before.anchors_mm)[touching], axis=1)
    total = float(weight.sum())
    return float(weight @ way) / total if total > 0 else 0.0


UP = np.array([0.0, 0.0, 1.0])


def travel(
    sensor: Sensor, start: FrameState, end: FrameState, deformation: Deformation, area_mm2: Array
) -> tuple[Deformation, float]:
    """The equilibrium at the end, and the way of slip until then [mm].

    Args:
        sensor: Solves.
        start: Where the object was.
        end: Where it goes, in a straight line.
        deformation: The equilibrium at the start.
        area_mm2: Of each contact point, see `contact_areas_mm2`.

    Raises:
        ConvergenceError: No valid equilibrium was found somewhere on the way.
    """
    slid_mm, has_friction = 0.0, sensor.contact.friction > 0
    reach = sensor.lattice.zone.radius_mm if sensor.lattice.zone is not None else 0.0
    if not start.can_touch:
        deformation = sensor.rest
    lever = sensor.object.shape().support_mm(UP) if sensor.object is not None else 0.0
    way = waypoints(start, end, has_friction=has_friction, reach_mm=reach, lever_mm=lever)
    for each in way:
        before, deformation = deformation, sensor.deform(each, deformation)
        slid_mm += slip_mm(before, deformation, area_mm2)
    return sensor.rest if deformation.is_rest or not way else deformation, slid_mm


def contact_areas_mm2(sensor: Sensor) -> Array:
    """Rest area of each contact point, shape (points,) [mm2]."""
    target = sensor.object
    spacing = {"point_spacing_mm": point_spacing_mm(target.shape())} if target is not None else {}
    return contact_face(sensor.lattice, **spacing).area_mm2
