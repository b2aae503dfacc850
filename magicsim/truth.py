"""Ground truth of one frame, from the state and the deformation behind it."""

import numpy as np
import numpy.typing as npt
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import cKDTree

from magicsim.deform.deformation import Deformation
from magicsim.detectors.truth import classify_frame
from magicsim.episode import FrameTruth, SolveFigures, Vector
from magicsim.scenes.timeline import FrameState

TOUCHING_GAP_MM = 0.01
"""Contact points nearer to the object than this count as touching [mm], as in the solver's contact area."""


def frame_truth(
    state: FrameState, deformation: Deformation, *, index: int, time_s: float, is_reference: bool
) -> FrameTruth:
    """What is true of a frame.

    Args:
        state: Where object and light are.
        deformation: Equilibrium of the lattice.
        index: Place in the stream.
        time_s: Time from the first frame [s].
        is_reference: Whether the frame is one of the references.
    """
    force = _vector(deformation.force_n)
    size = float(np.linalg.norm(deformation.force_n))
    return FrameTruth(
        index=index,
        time_s=time_s,
        is_reference=is_reference,
        state=state,
        contact=size > 0,
        depth_mm=max(0.0, -state.gap_mm) if state.gap_mm is not None else 0.0,
        force_n=force,
        torque_nmm=_vector(deformation.torque_nmm),
        contact_area_mm2=deformation.contact_area_mm2,
        frame_class=classify_frame(
            gap_mm=state.gap_mm, force_n=size, light_on=state.flashlight, is_reference=is_reference
        ),
        solve=SolveFigures(
            iterations=deformation.iterations,
            min_jacobian=deformation.min_jacobian,
            max_penetration_mm=deformation.max_penetration_mm,
            force_balance=deformation.force_balance,
        ),
    )


def contact_mask(deformation: Deformation, landing_mm: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Pixels whose ray, refracted at the flat lens side, lands where the face touches the object.

    The gap decides, not the traction: with pointwise multipliers the tractions of touching points alternate.

    Args:
        deformation: Equilibrium of the lattice.
        landing_mm: Where each pixel looks on the contact face, shape (rows, columns, 2) [mm].

    Returns:
        Mask of shape (rows, columns).
    """
    touching = deformation.contact_gap_mm <= TOUCHING_GAP_MM
    if not touching.any():
        return np.zeros(landing_mm.shape[:2], bool)
    _, nearest = cKDTree(deformation.contact_points_mm[:, :2]).query(landing_mm.reshape(-1, 2))
    return np.asarray(touching[nearest].reshape(landing_mm.shape[:2]))


def depth_map_mm(deformation: Deformation, landing_mm: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """How far the contact face is pressed in where each pixel's ray meets it; below zero where it bulges out.

    Linear between the deformed contact points; rays are those of the undeformed sensor, as for the contact mask.

    Args:
        deformation: Equilibrium of the lattice.
        landing_mm: Where each pixel looks on the contact face, shape (rows, columns, 2) [mm].

    Returns:
        Shape (rows, columns) [mm].
    """
    if deformation.is_rest:
        return np.zeros(landing_mm.shape[:2], np.float32)
    points, pixels = deformation.contact_points_mm, landing_mm.reshape(-1, 2)
    depth = LinearNDInterpolator(points[:, :2], points[:, 2])(pixels)
    outside = np.isnan(depth)
    if outside.any():
        _, nearest = cKDTree(points[:, :2]).query(pixels[outside])
        depth[outside] = points[nearest, 2]
    return np.asarray(depth.reshape(landing_mm.shape[:2]), np.float32)


def _vector(values: npt.NDArray[np.float64]) -> Vector:
    x, y, z = values.tolist()
    return (x, y, z)
