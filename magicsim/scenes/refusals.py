"""What no image can be made of: a sensor, or an object where it is. For scenes, and for sensors that have none."""

import math

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.projection import view_problem
from magicsim.geometry.coat import OpaqueCoat
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.markers import DotMarkers, PictureMarkers
from magicsim.scenes.rig import Rig

HOUSING_RADIUS = 1.2
"""Radius of the housing that keeps the light of the room from camera and lens, in half diagonals of the footprint."""
BEHIND_MM, AROUND_LAMP_MM = 1.0, 1.0
"""How far behind the pinhole and around lights the housing ends [mm]."""
_GREY = (
    "must be grey where the sensor sees through its face or scatters, because recorded paths know no colours; "
    "render.anchor_samples = 0 takes any"
)


def sensor_refusal(design: ElastomerDesign, rig: Rig, *, is_recorded: bool) -> str | None:
    """Why no image can be made, or by `RenderSettings.is_recorded` no path recorded, in one line, or None."""
    if is_recorded and (problem := _colored(design)) is not None:
        return problem
    if rig.moving is not None and not is_recorded:
        return (
            "rig.passing is not allowed without recorded light: must be left out, or render.estimator = 'fluence' "
            "and render.anchor_samples at least 1; rig.room = 'office' is a still room"
        )
    if design.mounting.base != "bonded":
        return (
            "design.mounting.base = 'table' is not allowed in a scene: must be 'bonded', since an image is of a "
            "block in contact with its lens; `press` takes both"
        )
    top = design.height_mm + rig.lens.thickness_mm
    leds = (led.problem(number, design.footprint_mm, top) for number, led in enumerate(rig.leds))
    found = (sensor_problem(design, rig), *leds, view_problem(design, rig.lens, rig.camera))
    return next((problem for problem in found if problem is not None), None)


def _colored(design: ElastomerDesign) -> str | None:
    if design.is_opaque and not design.scatters:
        return None
    painted = {"coat": design.coat if isinstance(design.coat, OpaqueCoat) else None, "markers": design.markers}
    for name, what in painted.items():
        if isinstance(what, PictureMarkers) and not what.is_grey:
            return f"design.markers.file = '{what.file}' is not allowed: {_GREY}"
        if isinstance(what, OpaqueCoat | DotMarkers) and len(set(what.color)) > 1:
            return f"design.{name}.color = {list(what.color)} is not allowed: {_GREY}"
    return None


def gap_refusal(design: ElastomerDesign, rig: Rig, gap_mm: float) -> str | None:
    """Why an object cannot be at a gap, negative when pressed, to follow its field's name, or None where it can."""
    deepest, passing = -MAX_DEPTH_SHARE * design.height_mm, rig.moving
    refused = f" = {gap_mm:g} is not allowed: "
    if gap_mm < deepest:
        return f"{refused}must be at least {deepest:g}, 90 % of the block's height"
    if passing is not None and gap_mm >= passing.distance_mm:
        return (
            f"{refused}outside of the room, in which something passes at rig.passing.distance_mm = "
            f"{passing.distance_mm:g}; must be below that"
        )
    if rig.near_mm is not None and gap_mm >= rig.near_mm:
        place = f"whose picture is at rig.room_distance_mm = {rig.near_mm:g}"
        return f"{refused}outside of the room, {place}; must be below that"
    return None


def opening_mm(design: ElastomerDesign) -> float:
    """Radius of the opening in which the block stands, at the lower end of its housing [mm]."""
    return HOUSING_RADIUS * float(np.linalg.norm(design.footprint_mm)) / 2


def housing_mm(design: ElastomerDesign, rig: Rig) -> tuple[float, float]:
    """Radius of the housing, in which all lights above the face are, and its height over the contact face [mm]."""
    radius = opening_mm(design)
    top = design.height_mm + rig.lens.thickness_mm + rig.camera.distance_mm + BEHIND_MM
    for aside, height, size in lamps_mm(design, rig).values():
        if height > 0:
            radius = max(radius, aside + size + AROUND_LAMP_MM)
            top = max(top, height + size + AROUND_LAMP_MM)
    return radius, top


def lamps_mm(design: ElastomerDesign, rig: Rig) -> dict[str, tuple[float, float, float]]:
    """Distance from the axis, height over the contact face and radius of single LEDs and ring, by field [mm]."""
    found = {}
    for number, led in enumerate(rig.leds):
        found[f"rig.leds.{number}"] = math.hypot(*led.place_mm[:2]), led.place_mm[2], led.radius_mm
    if rig.ring is not None:
        height = design.height_mm + rig.lens.thickness_mm + rig.ring.gap_mm
        found["rig.ring"] = rig.ring.radius_mm, height, rig.ring.width_mm / 2
    return found


def sensor_problem(design: ElastomerDesign, rig: Rig) -> str | None:
    """Why a sensor does not fit into its room, or None where it does, or where the room is far away."""
    if rig.near_mm is None or design.is_opaque:
        return None
    reaches = {"the housing of the sensor": math.hypot(*housing_mm(design, rig))}
    for name, (aside, height, size) in lamps_mm(design, rig).items():
        reaches[name] = math.hypot(aside, height) + size
    name, reach_mm = max(reaches.items(), key=lambda each: each[1])
    return _problem(name, reach_mm, rig.near_mm)


def flashlight_problem(rig: Rig, shift_x_mm: float) -> str | None:
    """Why the flashlight does not fit into the room, or None where it does."""
    light = rig.flashlight
    aside = math.hypot(light.x_mm + shift_x_mm, light.y_mm) + light.radius_mm
    return _problem("the flashlight", math.hypot(aside, light.distance_mm), rig.near_mm)


def object_problem(rig: Rig, vertices: Array) -> str | None:
    """Why an object does not fit into the room, or None where it does."""
    return _problem("the object", float(np.linalg.norm(vertices, axis=1).max()), rig.near_mm)


def _problem(name: str, reach_mm: float, room_mm: float | None) -> str | None:
    if room_mm is None or reach_mm < room_mm:
        return None
    return (
        f"rig.room_distance_mm = {room_mm:g} is not allowed: outside of the room would be {name}, which reaches "
        f"{reach_mm:.4g} mm from the middle of the contact face; must be above that"
    )
