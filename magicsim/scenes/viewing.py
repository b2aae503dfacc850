"""Where each pixel looks: the pinhole's field of view through the flat lens face, with refraction."""

import numpy as np
import numpy.typing as npt

from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

Array = npt.NDArray[np.float64]


def horizontal_fov_deg(design: ElastomerDesign, rig: Rig) -> float:
    """Full horizontal field of view [degrees] that covers `camera.field_mm` on the contact face.

    Solved by bisection on the monotone map from slope to landing point (Snell's law at the lens face).
    """
    low, high = 0.0, 100.0
    for _ in range(100):
        middle = (low + high) / 2
        reach = float(_landing(np.array([middle]), np.array([0.0]), design, rig)[0][0])
        low, high = (middle, high) if reach < rig.camera.field_mm / 2 else (low, middle)
    return float(2 * np.degrees(np.arctan(high)))


def pixel_landing_mm(design: ElastomerDesign, rig: Rig) -> Array:
    """Where the ray through each pixel's centre meets the undeformed contact face.

    Returns:
        x and y in the sensor's frame, shape (rows, columns, 2) [mm].
    """
    camera = rig.camera
    half = np.tan(np.radians(horizontal_fov_deg(design, rig) / 2))
    x_slope = half * ((np.arange(camera.columns) + 0.5) * 2 / camera.columns - 1)
    y_slope = half * camera.rows / camera.columns * (1 - (np.arange(camera.rows) + 0.5) * 2 / camera.rows)
    x_grid, y_grid = np.meshgrid(x_slope, y_slope)
    x, y = _landing(x_grid, y_grid, design, rig)
    return np.stack([x, y], -1)


def _landing(x_slope: Array, y_slope: Array, design: ElastomerDesign, rig: Rig) -> tuple[Array, Array]:
    depth = design.height_mm + rig.lens.thickness_mm
    squared = x_slope**2 + y_slope**2
    sine = np.sqrt(squared / (1 + squared)) / design.materials.body.ior
    ratio = sine / np.sqrt(1 - sine**2) / np.maximum(np.sqrt(squared), 1e-30)
    reach = rig.camera.distance_mm + depth * ratio
    return x_slope * reach, y_slope * reach
