"""Where each pixel looks: the pinhole's field of view through the flat lens face, with refraction."""

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera, Lens
from magicsim.geometry.design import ElastomerDesign

LANDING_STEPS = 12
MAX_FOV_DEG = 170.0
"""Widest field of view of a pinhole: beyond it a pixel's solid angle falls to nothing towards the edges."""


def horizontal_fov_deg(design: ElastomerDesign, lens: Lens, camera: Camera) -> float:
    """Full horizontal field of view [degrees] that covers `camera.field_mm` on the contact face.

    Solved by bisection on the monotone map from slope to landing point (Snell's law at the lens face).
    """
    low, high = 0.0, 100.0
    for _ in range(100):
        middle = (low + high) / 2
        reach = float(_landing(np.array([middle]), np.array([0.0]), design, lens, camera)[0][0])
        low, high = (middle, high) if reach < camera.field_mm / 2 else (low, middle)
    return float(2 * np.degrees(np.arctan(high)))


def view_problem(design: ElastomerDesign, lens: Lens, camera: Camera) -> str | None:
    """Why a camera would have to look nearly sideways to see its field, or None where it would not."""
    fov = horizontal_fov_deg(design, lens, camera)
    if fov <= MAX_FOV_DEG:
        return None
    return (
        f"rig.camera.field_mm = {camera.field_mm:g} is not allowed with rig.camera.distance_mm = "
        f"{camera.distance_mm:g}: the field of view of {fov:.0f} degrees must be at most {MAX_FOV_DEG:g}"
    )


def focal_px(design: ElastomerDesign, lens: Lens, camera: Camera) -> float:
    """Focal length of the pinhole in air [px]."""
    return float(camera.columns / 2 / np.tan(np.radians(horizontal_fov_deg(design, lens, camera) / 2)))


def landing_mm(
    slopes: Array, design: ElastomerDesign, lens: Lens, camera: Camera, *, z_mm: float | Array = 0.0
) -> Array:
    """Where rays meet a plane of the undeformed block, x and y in the sensor's frame, shape (..., 2) [mm].

    Slopes are directions in air from the pinhole, right and down per unit along the axis, shape (..., 2).
    """
    x, y = _landing(slopes[..., 0], -slopes[..., 1], design, lens, camera, z_mm)
    return np.stack([x, y], -1)


def face_landing_mm(slopes: Array, design: ElastomerDesign, lens: Lens, camera: Camera) -> Array:
    """Where rays from the pinhole meet the undeformed contact face, curved or not; arguments as above.

    Fixed point of the height at which a ray lands: rays are steep and faces are not, so that each step gains a digit.
    """
    found = landing_mm(slopes, design, lens, camera)
    if design.face is None:
        return found
    for _ in range(LANDING_STEPS):
        found = landing_mm(slopes, design, lens, camera, z_mm=design.rise_mm(found))
    return found


def _landing(
    x_slope: Array, y_slope: Array, design: ElastomerDesign, lens: Lens, camera: Camera, z_mm: float | Array = 0.0
) -> tuple[Array, Array]:
    depth = design.height_mm + lens.thickness_mm - z_mm
    squared = x_slope**2 + y_slope**2
    sine = np.sqrt(squared / (1 + squared)) / design.materials.body.ior
    ratio = sine / np.sqrt(1 - sine**2) / np.maximum(np.sqrt(squared), 1e-30)
    reach = camera.distance_mm + depth * ratio
    return x_slope * reach, y_slope * reach
