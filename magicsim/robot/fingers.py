"""Two facing sensors: the frame of each finger, and the object as each of them sees it.

The gripper's frame is right-handed, its origin midway between the two contact faces, z along the closing axis, y along
the 32 mm side of both fingertips (row 0 of both images at +y). The upper finger is at +z, its axes parallel to the
gripper's. The lower finger is the upper one turned by half a turn about y:

    upper: x = x_g,  y = y_g, z = z_g - width / 2
    lower: x = -x_g, y = y_g, z = -z_g - width / 2

So both are the same part, LEDs included, and an object that half a turn about y leaves as it is gives both the same
image, not mirrored. An object on the gripper's +x side is on the right of the upper image and on the left of the lower.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.geometry.pose import Pose

Side = Literal["upper", "lower"]
SIDES: tuple[Side, Side] = ("upper", "lower")
ROUNDING_MM = 1e-9
"""Gap below which an object just touches [mm]: what is left of three numbers that add up to nothing."""
TO_GRIPPER: dict[Side, Array] = {"upper": np.eye(3), "lower": np.diag([-1.0, 1.0, -1.0])}
"""Rotation from each finger's frame to the gripper's; each is its own inverse."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectPlace:
    """Where the object is between the fingers, in the gripper's frame."""

    x_mm: float = 0.0
    """Object's origin along x [mm]."""
    y_mm: float = 0.0
    """Along y [mm]."""
    z_mm: float = 0.0
    """Along the closing axis [mm]; 0 is midway."""
    twist_deg: float = 0.0
    """Rotation about z, added to the object's own yaw [degrees]."""
    tilt_x_deg: float = 0.0
    """Tilt after the twist, a rotation vector about the object's origin: along x [degrees]."""
    tilt_y_deg: float = 0.0
    """Along y [degrees]."""


def finger_pose(side: Side, width_mm: float) -> Pose:
    """The transform from a finger's frame to the gripper's: p_gripper = rotation @ p_finger + position."""
    rotation = TO_GRIPPER[side]
    return Pose(position_mm=rotation @ np.array([0.0, 0.0, width_mm / 2]), rotation=rotation)


def seen_by_lower(target: AnyObject) -> AnyObject:
    """The object with its orientation in the lower finger's frame; in the upper one's it is the gripper's.

    Half a turn about y before Rz(yaw) Ry(pitch) Rx(roll) is Rz(-yaw) Ry(180 + pitch) Rx(roll).
    """
    return target.model_copy(update={"pitch_deg": target.pitch_deg + 180.0, "yaw_deg": -target.yaw_deg})


def object_pose(target: AnyObject, place: ObjectPlace) -> Pose:
    """The transform from the object's frame to the gripper's."""
    position = np.array([place.x_mm, place.y_mm, place.z_mm])
    angles = {"roll": target.roll_deg, "pitch": target.pitch_deg, "yaw": target.yaw_deg + place.twist_deg}
    return Pose.from_degrees(position, **angles).tilted((place.tilt_x_deg, place.tilt_y_deg))


def half_extents_mm(target: AnyObject, place: ObjectPlace | None = None) -> tuple[float, float]:
    """How far an object, not tilted by default, reaches from its origin towards upper and lower finger [mm]."""
    up = object_pose(target, place or ObjectPlace()).rotation[2]
    shape = target.shape()
    return shape.support_mm(up), shape.support_mm(-up)


def finger_motion(side: Side, place: ObjectPlace, width_mm: float, reaches_mm: tuple[float, float]) -> dict[str, float]:
    """The object in a finger's own frame, as `move_to` takes it: gap, x, y [mm], twist, tilts [degrees].

    Reaches are those of the object's origin from the upper and the lower face when it first touches that one.
    """
    sign = 1.0 if side == "upper" else -1.0
    reach = reaches_mm[0] if side == "upper" else reaches_mm[1]
    gap = width_mm / 2 - sign * place.z_mm - reach
    return {
        "gap_mm": gap if abs(gap) > ROUNDING_MM else 0.0,
        "x_mm": sign * place.x_mm,
        "y_mm": place.y_mm,
        "twist_deg": sign * place.twist_deg,
        "tilt_x_deg": sign * place.tilt_x_deg,
        "tilt_y_deg": place.tilt_y_deg,
    }
