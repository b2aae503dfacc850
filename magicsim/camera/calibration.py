"""What a camera calibration would find: intrinsics, distortion, and millimetres per pixel at every layer."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from magicsim.camera.camera import Camera, Lens
from magicsim.camera.projection import camera_matrix, pixel_landing_mm
from magicsim.camera.viewing import focal_px
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import resolve_grid


@dataclass(frozen=True, slots=True, kw_only=True)
class LayerScale:
    """One plane of the undeformed block as the camera sees it."""

    name: str
    """`contact face`, `grid 0` and so on, `bonded face`."""
    z_mm: float
    mm_per_pixel: tuple[float, float]
    """Along the image's columns and rows, at the pixel nearest to the optical axis [mm/px]."""
    mm_per_pixel_corner: tuple[float, float]
    """Along columns and rows at the first corner [mm/px]."""
    field_mm: tuple[float, float]
    """From the centre of the first pixel to that of the last, of the middle row and of the middle column [mm]."""


class HasCamera(Protocol):
    """A camera and the lens plate in front of it, as every rig has them."""

    @property
    def lens(self) -> Lens:
        """Plate in front of the block's bonded face."""

    @property
    def camera(self) -> Camera:
        """Pinhole behind it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraCalibration:
    """What is known of one camera; OpenCV's conventions, whole coordinates at pixel centres."""

    image_size: tuple[int, int]
    """Columns and rows [px]."""
    camera_matrix: tuple[tuple[float, ...], ...]
    """Intrinsics in air, shape (3, 3) [px]."""
    distortion: tuple[float, ...]
    """k1, k2, p1, p2, k3."""
    pinhole_z_mm: float
    """Height of the pinhole in the sensor's frame; the optical axis is the z axis [mm]."""
    lens_face_z_mm: float
    """Height of the plane face at which rays refract on their way to the pinhole [mm]."""
    ior: float
    """Refractive index below that face."""
    layers: tuple[LayerScale, ...]


@lru_cache(maxsize=2)
def calibrate_camera(design: ElastomerDesign, rig: HasCamera) -> CameraCalibration:
    """The calibration of a design on a rig.

    Raises:
        GeometryError: The grid does not fit the block.
        RenderError: The distortion folds the image.
    """
    lens, camera, window = rig.lens, rig.camera, rig.camera.window
    focal = focal_px(design, lens, camera)
    matrix = camera_matrix(camera, focal)
    matrix[:2, 2] -= [window.column, window.row]
    face = design.height_mm + lens.thickness_mm
    return CameraCalibration(
        image_size=(window.columns, window.rows),
        camera_matrix=tuple(tuple(row) for row in matrix.tolist()),
        distortion=camera.distortion,
        pinhole_z_mm=face + camera.distance_mm,
        lens_face_z_mm=face,
        ior=design.materials.body.ior,
        layers=tuple(_layer(name, z, design, lens, camera) for name, z in _planes(design)),
    )


def _planes(design: ElastomerDesign) -> list[tuple[str, float]]:
    grid = resolve_grid(design)
    printed = grid.planes_mm(2).tolist() if grid is not None else []
    between = [(f"grid {number}", z) for number, z in enumerate(printed)]
    return [("contact face", 0.0), *between, ("bonded face", design.height_mm)]


def _layer(name: str, z_mm: float, design: ElastomerDesign, lens: Lens, camera: Camera) -> LayerScale:
    landing = pixel_landing_mm(design, lens, camera, z_mm=z_mm)
    across = np.linalg.norm(np.diff(landing, axis=1), axis=2)
    down = np.linalg.norm(np.diff(landing, axis=0), axis=2)
    row, column = np.unravel_index(np.linalg.norm(landing, axis=2).argmin(), landing.shape[:2])
    middle_row, middle_column = landing[landing.shape[0] // 2], landing[:, landing.shape[1] // 2]
    return LayerScale(
        name=name,
        z_mm=z_mm,
        mm_per_pixel=(
            float(across[row, min(int(column), across.shape[1] - 1)]),
            float(down[min(int(row), down.shape[0] - 1), column]),
        ),
        mm_per_pixel_corner=(float(across[0, 0]), float(down[0, 0])),
        field_mm=(
            float(np.linalg.norm(middle_row[-1] - middle_row[0])),
            float(np.linalg.norm(middle_column[-1] - middle_column[0])),
        ),
    )
