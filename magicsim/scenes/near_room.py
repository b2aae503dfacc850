"""What has to fit into a room that is near: the sensor with its housing and lamps, and whatever comes."""

import math

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

HOUSING_RADIUS = 1.2
"""Radius of the housing that keeps the light of the room from camera and lens, in half diagonals of the footprint."""
BEHIND_MM = 1.0
"""How far behind the pinhole the housing ends [mm]."""


def housing_mm(design: ElastomerDesign, rig: Rig) -> tuple[float, float]:
    """Radius of the housing and its height over the contact face [mm].

    Args:
        design: The block.
        rig: What surrounds it.
    """
    radius = HOUSING_RADIUS * float(np.linalg.norm(design.footprint_mm)) / 2
    return radius, design.height_mm + rig.lens.thickness_mm + rig.camera.distance_mm + BEHIND_MM


def sensor_problem(design: ElastomerDesign, rig: Rig) -> str | None:
    """Why a sensor does not fit into its room, or None where it does, or where the room is far away.

    Args:
        design: The block.
        rig: What surrounds it.
    """
    if rig.near_mm is None or design.is_opaque:
        return None
    reaches = {"the housing of the sensor": math.hypot(*housing_mm(design, rig))}
    for number, led in enumerate(rig.leds):
        reaches[f"rig.leds.{number}"] = math.hypot(*led.place_mm) + led.radius_mm
    if rig.ring is not None:
        height = design.height_mm + rig.lens.thickness_mm + rig.ring.gap_mm
        reaches["rig.ring"] = math.hypot(rig.ring.radius_mm + rig.ring.width_mm / 2, height)
    name, reach_mm = max(reaches.items(), key=lambda each: each[1])
    return _problem(name, reach_mm, rig.near_mm)


def flashlight_problem(rig: Rig, shift_x_mm: float) -> str | None:
    """Why the flashlight does not fit into the room, or None where it does.

    Args:
        rig: Its room and flashlight.
        shift_x_mm: Shift of the flashlight along x [mm].
    """
    light = rig.flashlight
    aside = math.hypot(light.x_mm + shift_x_mm, light.y_mm) + light.radius_mm
    return _problem("the flashlight", math.hypot(aside, light.distance_mm), rig.near_mm)


def object_problem(rig: Rig, vertices: Array) -> str | None:
    """Why an object does not fit into the room, or None where it does.

    Args:
        rig: Its room.
        vertices: Of the object where it is, shape (vertices, 3) [mm].
    """
    return _problem("the object", float(np.linalg.norm(vertices, axis=1).max()), rig.near_mm)


def _problem(name: str, reach_mm: float, room_mm: float | None) -> str | None:
    if room_mm is None or reach_mm < room_mm:
        return None
    return (
        f"rig.room_distance_mm = {room_mm:g} is not allowed: outside of the room would be {name}, which reaches "
        f"{reach_mm:.4g} mm from the middle of the contact face; must be above that"
    )
