"""Where the camera sees a point inside the block: the way back from a place to its pixel, refraction included.

The camera looks through the bonded face, which never moves: the same rays hold for a deformed block. Refraction at
the cells of the grid is left out, as in the calibration; it is part of what is seen, not of where a label stands.
"""

import cv2
import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera, Lens
from magicsim.camera.film import camera_matrix
from magicsim.camera.viewing import focal_px
from magicsim.geometry.design import ElastomerDesign

STEPS = 60
"""Bisections; each halves the interval of slopes."""


def project_px(points_mm: Array, design: ElastomerDesign, lens: Lens, camera: Camera) -> Array:
    """Pixels at which the camera sees points of the block.

    Args:
        points_mm: Positions in the sensor's frame, deformed where they are, shape (..., 3) [mm].
        design: The block.
        lens: Plate in front of the block's bonded face.
        camera: Pinhole behind it.

    Returns:
        Column and row in the image that is read out, whole at pixel centres, shape (..., 2) [px]; may lie outside.
    """
    focal = focal_px(design, lens, camera)
    reach = np.linalg.norm(points_mm[..., :2], axis=-1)
    depth = design.height_mm + lens.thickness_mm - points_mm[..., 2]
    slope = _slope(reach, depth, camera.distance_mm, design.materials.body.ior)
    across = points_mm[..., :2] * (slope / np.maximum(reach, 1e-30))[..., None]
    rays = np.stack([across[..., 0], -across[..., 1], np.ones_like(slope)], -1).reshape(-1, 3)
    matrix, still = camera_matrix(camera, focal), np.zeros(3)
    pixels = cv2.projectPoints(rays, still, still, matrix, np.array(camera.distortion))[0].reshape(across.shape)
    return np.asarray(pixels - [camera.window.column, camera.window.row], float)


def _slope(reach: Array, depth: Array, distance_mm: float, ior: float) -> Array:
    """Slope in air of the ray from the pinhole that ends at a distance from the axis, at a depth below the lens face.

    Snell's law at the face: distance * s + depth * tan(asin(sin(atan(s)) / n)) = reach, which grows with s.
    """
    low, high = np.zeros_like(reach), reach / distance_mm
    for _ in range(STEPS):
        middle = (low + high) / 2
        sine = middle / np.sqrt(1 + middle**2) / ior
        is_short = distance_mm * middle + depth * sine / np.sqrt(1 - sine**2) < reach
        low, high = np.where(is_short, middle, low), np.where(is_short, high, middle)
    return np.asarray((low + high) / 2)
