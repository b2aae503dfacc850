"""Mirror planes that a contact has, and what they leave of its force and torque.

Where block, face, object and path are their own mirror images in the plane x = 0, so is the equilibrium that the path
reaches. A force has no component across a mirror plane, and a torque, which is an axial vector, none in it: x = 0
leaves F_y, F_z and T_x. A solve meets that to its tolerance; what is within it is exactly zero.
"""

from collections.abc import Sequence

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.indenter import Indenter

PLANE_SHARE = 1e-9
"""Largest distance of mirrored node planes, in units of the block's size."""
SHAPE_MM = 1e-6
"""Largest difference of an object's distances at mirrored points [mm]: meshes of solids round."""
FORCE_SHARE = 1e-5
"""Largest solved component that counts as zero, in units of the force; equilibria are solved to 1e-7 or so. More of it
is a body that has buckled out of its symmetry, and stays what it is."""
LEVELS = 4
"""Heights of the face at which an object is compared with its mirror image."""


def mirror_planes(lattice: Lattice, face_mm: Array, poses: Sequence[Indenter]) -> tuple[bool, bool]:
    """Whether a path of an object on a block is its own mirror image in x = 0, and in y = 0.

    Args:
        lattice: The block.
        face_mm: Contact points of its undeformed face, shape (points, 3) [mm].
        poses: Of the object, all along its path.
    """
    return _mirrors(lattice, face_mm, poses, 0), _mirrors(lattice, face_mm, poses, 1)


def left_by_mirrors(force_n: Array, torque_nmm: Array, planes: tuple[bool, bool], reach_mm: float) -> Array:
    """Force and torque, shape (2, 3) [N, N mm]; exactly zero where mirror planes leave nothing.

    Args:
        force_n: As solved, shape (3,) [N].
        torque_nmm: As solved, about a point of both planes, shape (3,) [N mm].
        planes: Whether x = 0 and y = 0 mirror the contact.
        reach_mm: Largest lever of the force [mm].
    """
    found = np.stack([force_n, torque_nmm]).astype(np.float64)
    least = FORCE_SHARE * float(np.linalg.norm(force_n)) * np.array([1.0, reach_mm])
    for axis, mirrors in enumerate(planes):
        gone = np.zeros((2, 3), bool)
        gone[0, axis] = gone[1, 1 - axis] = gone[1, 2] = True
        if mirrors and (np.abs(found) <= least[:, None])[gone].all():
            found[gone] = 0.0
    return found


def _mirrors(lattice: Lattice, face_mm: Array, poses: Sequence[Indenter], axis: int) -> bool:
    planes = lattice.planes_mm[axis]
    if lattice.is_mirrored or np.abs(planes + planes[::-1]).max() > PLANE_SHARE * float(np.ptp(planes)):
        return False
    cells = tuple(len(each) - 1 for each in reversed(lattice.planes_mm))
    moduli = (lattice.shear_modulus_mpa, lattice.wall_modulus_mpa, lattice.lame_mpa)
    if not all(np.array_equal(each.reshape(cells), np.flip(each.reshape(cells), 2 - axis)) for each in moduli):
        return False
    return all(_is_own_image(pose, face_mm, axis) for pose in poses)


def _is_own_image(indenter: Indenter, face_mm: Array, axis: int) -> bool:
    """Whether an object's distance is even across the plane, at the face and at the heights that it was lifted to."""
    flip = np.ones(3)
    flip[axis] = -1
    for level in np.linspace(0, max(indenter.top_mm(), 0.0), LEVELS):
        points = face_mm + np.array([0.0, 0.0, level])
        here, there = (indenter.distance(each)[0] for each in (points, points * flip))
        if np.abs(here - there).max() > SHAPE_MM:
            return False
    return True
