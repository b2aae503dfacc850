"""Ground truth of one frame, from the state and the deformation behind it."""

import numpy as np
import numpy.typing as npt
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import POINT_SPACING_MM
from magicsim.deform.deformation import Deformation, SolveFigures
from magicsim.deform.indentation.path import as_vector
from magicsim.frame_class import classify_frame
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.limits import PressLimits
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.episode import FrameTruth

AROUND_MM = 2 * POINT_SPACING_MM
"""Beyond a touching point there is another that does not touch within this distance [mm]."""


def frame_truth(
    state: FrameState, deformation: Deformation, limits: PressLimits, *, index: int, time_s: float, is_reference: bool
) -> FrameTruth:
    """What is true of a frame."""
    force = as_vector(deformation.force_n)
    size = float(np.linalg.norm(deformation.force_n))
    depth = max(0.0, -state.gap_mm) if state.gap_mm is not None else 0.0
    return FrameTruth(
        index=index,
        time_s=time_s,
        is_reference=is_reference,
        state=state,
        contact=size > 0,
        depth_mm=depth,
        force_n=force,
        torque_nmm=as_vector(deformation.torque_nmm),
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
        beyond_limits=limits.excess(depth_mm=depth, force_n=force[2], area_mm2=deformation.contact_area_mm2),
        dissipated_nmm=deformation.core.dissipated_nmm if deformation.core is not None else None,
    )


def is_in_view(state: FrameState, deformation: Deformation, view_mm: Array) -> bool:
    """Whether a picture covers the middle of what touches, or the place that an object stands before."""
    if state.gap_mm is None:
        return True
    pressure = deformation.contact_pressure_mpa
    place = np.array([state.x_mm, state.y_mm])
    if pressure.sum() > 0:
        place = np.average(deformation.contact_points_mm[:, :2], axis=0, weights=pressure)
    return bool(((view_mm[0] <= place) & (place <= view_mm[1])).all())


def contact_mask(deformation: Deformation, landing_mm: Array) -> Mask:
    """Pixels whose ray, refracted at the flat lens side, lands where the face touches the object.

    The gap decides, linear between contact points, not the traction: with pointwise multipliers the tractions of
    touching points alternate.

    `landing_mm` is where each pixel looks on the contact face; the mask has the shape (rows, columns).
    """
    points = deformation.contact_points_mm[:, :2]
    apart = deformation.contact_gap_mm - deformation.touches_within_mm
    touching, mask = points[apart <= 0], np.zeros(landing_mm.shape[:2], bool)
    if len(touching):
        looked_at = _in_box(landing_mm, touching, AROUND_MM)
        near = _in_box(points, touching, 2 * AROUND_MM)
        mask[looked_at] = _between(points[near], apart[near], landing_mm[looked_at]) <= 0
    return mask


def depth_map_mm(
    deformation: Deformation, landing_mm: Array, design: ElastomerDesign | None = None
) -> npt.NDArray[np.float32]:
    """How far the contact face is pressed in where each pixel's ray meets it; below zero where it bulges out.

    Linear between the deformed contact points; rays are those of the undeformed sensor, as for the contact mask.

    Shape (rows, columns), along z from the undeformed face [mm].
    """
    if deformation.is_rest:
        return np.zeros(landing_mm.shape[:2], np.float32)
    points = deformation.contact_points_mm
    pressed = points[:, 2] - (design.rise_mm(points[:, :2]) if design is not None else 0.0)
    depth = _between(points[:, :2], pressed, landing_mm.reshape(-1, 2))
    return depth.reshape(landing_mm.shape[:2]).astype(np.float32)


def _in_box(places: Array, around: Array, margin_mm: float) -> Mask:
    """Which places are in the rectangle around others, widened by a margin."""
    low, high = around.min(0) - margin_mm, around.max(0) + margin_mm
    return np.asarray(((places >= low) & (places <= high)).all(-1))


def _between(points: Array, values: Array, places: Array) -> Array:
    """Linear between the values at points; the nearest one's beyond the outermost."""
    found = LinearNDInterpolator(points, values)(places)
    outside = np.isnan(found)
    if outside.any():
        _, nearest = cKDTree(points).query(places[outside])
        found[outside] = values[nearest]
    return np.asarray(found)
