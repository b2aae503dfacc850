"""What no image can be made of: a sensor, or an object where it is. For scenes, and for sensors that have none."""

from magicsim.camera.viewing import view_problem
from magicsim.geometry.coat import OpaqueCoat
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.markers import DotMarkers, PictureMarkers
from magicsim.scenes.near_room import sensor_problem
from magicsim.scenes.rig import Rig

_GREY = (
    "must be grey where the sensor sees through its face or scatters, because recorded paths know no colours; "
    "render.anchor_samples = 0 takes any"
)


def sensor_refusal(design: ElastomerDesign, rig: Rig, *, is_recorded: bool) -> str | None:
    """Why no image can be made of a sensor, in one line, or None where one can.

    Args:
        design: The block.
        rig: What surrounds it.
        is_recorded: Whether paths through the untouched sensor are to be recorded, see `RenderSettings.is_recorded`.
    """
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
            "block in contact with its lens; `press` and `durometer` take both"
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
    """Why an object cannot be at a gap, to follow its field's name, or None where it can.

    Args:
        design: The block.
        rig: What surrounds it.
        gap_mm: Of the object, negative when pressed [mm].
    """
    deepest, passing = -MAX_DEPTH_SHARE * design.height_mm, rig.moving
    told = f" = {gap_mm:g} is not allowed: "
    if gap_mm < deepest:
        return f"{told}must be at least {deepest:g}, 90 % of the block's height"
    if passing is not None and gap_mm >= passing.distance_mm:
        return (
            f"{told}outside of the room, in which something passes at rig.passing.distance_mm = "
            f"{passing.distance_mm:g}; must be below that"
        )
    if rig.near_mm is not None and gap_mm >= rig.near_mm:
        return (
            f"{told}outside of the room, whose picture is at rig.room_distance_mm = {rig.near_mm:g}; must be below that"
        )
    return None
