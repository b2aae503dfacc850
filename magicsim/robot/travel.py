"""Where an object's straight way ends in equilibrium, and how far the skin slid over it meanwhile."""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import contact_face, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.robot.motion import waypoints
from magicsim.robot.slip import slip_mm
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

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
    if not can_touch(start):
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
