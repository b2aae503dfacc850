"""The straight way of an object from one pose to another, turning about one axis."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.deform.deformation import Deformation
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose


def first_contact(indenter: Indenter) -> Pose:
    """The pose lowered until the object's highest point is level with the undeformed face."""
    return replace(indenter.pose, position_mm=indenter.pose.position_mm - [0.0, 0.0, indenter.top_mm()])


def way_length_mm(first: Pose, last: Pose, reach_mm: float) -> float:
    """Length of the way of the object's origin and of its points at a distance from the vertical through it [mm]."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).magnitude()
    return float(np.linalg.norm(last.position_mm - first.position_mm) + turn * reach_mm)


def reach_mm(state: Deformation, pose: Pose) -> float:
    """Largest distance of a pressed point of a state from the vertical through an object's origin [mm]."""
    touching = state.contact_points_mm[state.contact_pressure_mpa > 0] - pose.position_mm
    return float(np.linalg.norm(touching[:, :2], axis=1).max(initial=0.0))


def pose_between(first: Pose, last: Pose, share: float) -> Pose:
    """Pose on the straight way, turning about one axis."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).as_rotvec()
    rotation = Rotation.from_rotvec(share * turn).as_matrix() @ first.rotation
    return Pose(position_mm=(1 - share) * first.position_mm + share * last.position_mm, rotation=rotation)


def is_there(indenter: Indenter, state: Deformation) -> bool:
    """Whether a state is the equilibrium under this very object in this very pose, known by every gap."""
    if state.pose is None or not np.array_equal(state.pose.position_mm, indenter.pose.position_mm):
        return False
    gap = indenter.distance(state.contact_points_mm)[0]
    return np.array_equal(state.pose.rotation, indenter.pose.rotation) and np.array_equal(gap, state.contact_gap_mm)
