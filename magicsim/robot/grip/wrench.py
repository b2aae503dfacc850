"""Force and torque of a finger on the object, and how stiff its contact is, about the object's origin."""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.geometry.pose import Pose

SHEAR_SHARE = 2 / 3
"""Tangential by normal stiffness of a bonded round contact on an incompressible half space: (2 - 2 v) / (2 - v) at v =
1/2 (Mindlin 1949)."""
HERTZ = 1.5
"""Normal stiffness in units of force by depth, of a ball on a half space."""


def finger_wrench(deformation: Deformation, finger: Pose, origin_mm: Array) -> Array:
    """Force [N] and torque [N mm] of a finger on the object about its origin, in the gripper's frame, shape (6,).

    Args:
        deformation: The finger's equilibrium; its force and torque are the object's on it, about the finger's origin.
        finger: From the finger's frame to the gripper's.
        origin_mm: The object's origin in the gripper's frame, shape (3,) [mm].
    """
    force = -finger.rotation @ deformation.force_n
    torque = np.cross(finger.position_mm - origin_mm, force) - finger.rotation @ deformation.torque_nmm
    return np.concatenate([force, torque])


def contact_stiffness(deformation: Deformation, depth_mm: float, finger: Pose, origin_mm: Array) -> Array:
    """First estimate of how a finger's wrench answers small motions of the object, shape (6, 6) [N/mm, N, N mm].

    A round contact on a half space, sticking, of the force, depth and area that the equilibrium has.

    Args:
        deformation: The finger's equilibrium.
        depth_mm: How deep the object is pressed in [mm].
        finger: From the finger's frame to the gripper's.
        origin_mm: The object's origin in the gripper's frame, shape (3,) [mm].
    """
    force = float(deformation.force_n[2])
    if force <= 0 or depth_mm <= 0:
        return np.zeros((6, 6))
    normal = HERTZ * force / depth_mm
    square = deformation.contact_area_mm2 / np.pi
    own = np.array([SHEAR_SHARE, SHEAR_SHARE, 1.0, square / 3, square / 3, SHEAR_SHARE * square / 2]) * normal
    weight = deformation.contact_pressure_mpa
    centre = (weight @ deformation.contact_points_mm) / weight.sum()
    x, y, z = finger.to_sensor(centre[None])[0] - origin_mm
    carried = np.eye(6)  # motion of the contact's centre by that of the origin: u + theta x r
    carried[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return np.asarray(carried.T @ np.diag(own) @ carried)
