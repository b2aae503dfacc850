"""Where pixels look through the flat lens face, and the way back from a place in the block to its pixel.

The camera looks through the bonded face, which never moves: the same rays hold for a deformed block. Refraction at
the cells of the grid is left out, as in the calibration; it is part of what is seen, not of where a label stands.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import cv2
import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera, Lens
from magicsim.errors import RenderError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import resolve_grid

UNDISTORT_PX, MAX_UNDISTORT = 1e-4, 200
"""Largest error of the inverse of the distortion, and corrections after which it is taken to have none."""
LANDING_STEPS = 12
MAX_FOV_DEG = 170.0
"""Widest field of view of a pinhole: beyond it a pixel's solid angle falls to nothing towards the edges."""
STEPS = 60
"""Bisections; each halves the interval of slopes."""


def horizontal_fov_deg(design: ElastomerDesign, lens: Lens, camera: Camera) -> float:
    """Full horizontal field of view [degrees] that covers `camera.field_mm` on the contact face.

    Solved by bisection on the monotone map from slope to landing point (Snell's law at the lens face).
    """
    depth_mm = design.height_mm + lens.thickness_mm
    return _fov_deg(depth_mm, design.materials.body.ior, camera.distance_mm, camera.field_mm)


@lru_cache(maxsize=64)
def _fov_deg(depth_mm: float, ior: float, distance_mm: float, field_mm: float) -> float:
    low, high = 0.0, 100.0
    for _ in range(100):
        middle = (low + high) / 2
        reach = float(_landed_mm(np.array([[middle, 0.0]]), depth_mm, ior, distance_mm)[0, 0])
        low, high = (middle, high) if reach < field_mm / 2 else (low, middle)
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
    depth_mm = design.height_mm + lens.thickness_mm - z_mm
    return _landed_mm(slopes, depth_mm, design.materials.body.ior, camera.distance_mm)


def _landed_mm(slopes: Array, depth_mm: float | Array, ior: float, distance_mm: float) -> Array:
    x_slope, y_slope = slopes[..., 0], -slopes[..., 1]
    squared = x_slope**2 + y_slope**2
    sine = np.sqrt(squared / (1 + squared)) / ior
    ratio = sine / np.sqrt(1 - sine**2) / np.maximum(np.sqrt(squared), 1e-30)
    reach = distance_mm + depth_mm * ratio
    return np.stack([x_slope * reach, y_slope * reach], -1)


def project_px(points_mm: Array, design: ElastomerDesign, lens: Lens, camera: Camera) -> Array:
    """Column and row, shape (..., 2) [px], at which the camera sees points of the block, shape (..., 3) [mm].

    Points are where they are, deformed; pixels are whole at their centres in the image that is read out, and may lie
    outside.
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


def pixel_landing_mm(design: ElastomerDesign, lens: Lens, camera: Camera, *, z_mm: float = 0.0) -> Array:
    """Where the ray through each pixel's centre meets a plane of the undeformed block, the contact face by default.

    x and y in the sensor's frame, of the pixels that are read out, shape (rows, columns, 2) [mm].
    """
    slopes = camera.window.of(pixel_slopes(camera, focal_px(design, lens, camera)))
    return _layer_landing_mm(slopes, design, lens, camera, z_mm)


def _layer_landing_mm(slopes: Array, design: ElastomerDesign, lens: Lens, camera: Camera, z_mm: float) -> Array:
    """Where rays meet a plane or, with z = 0, the contact face, curved or not.

    Fixed point of the height at which a ray lands: rays are steep and faces are not, so that each step gains a digit.
    """
    found = landing_mm(slopes, design, lens, camera, z_mm=z_mm)
    for _ in range(LANDING_STEPS if z_mm == 0 and design.face is not None else 0):
        found = landing_mm(slopes, design, lens, camera, z_mm=design.rise_mm(found))
    return found


def picture_mm(design: ElastomerDesign, lens: Lens, camera: Camera) -> Array:
    """The upright rectangle of the contact face that the picture covers whole, its edges those of the outermost pixels.

    Smallest and largest x and y, shape (2, 2) [mm].
    """
    landing = pixel_landing_mm(design, lens, camera)
    low = [landing[:, 0, 0].max(), landing[-1, :, 1].max()]
    return np.array([low, [landing[:, -1, 0].min(), landing[0, :, 1].min()]])


def camera_matrix(camera: Camera, focal: float) -> Array:
    """OpenCV's intrinsic matrix; pixel centres have whole coordinates, shape (3, 3) [px]."""
    x, y = principal_px(camera)
    return np.array([[focal, 0.0, x], [0.0, focal, y], [0.0, 0.0, 1.0]])


def pixel_slopes(camera: Camera, focal: float) -> Array:
    """Directions of the pixels' rays, right and down per unit along the axis, shape (rows, columns, 2).

    `RenderError` where the distortion folds the image, so that some pixel sees no direction or several.
    """
    column, row = np.meshgrid(np.arange(camera.columns, dtype=float), np.arange(camera.rows, dtype=float))
    pixels = np.stack([column, row], -1)
    slopes: Array = (pixels - principal_px(camera)) / focal
    if not any(camera.distortion):
        return np.asarray(slopes)
    matrix, lens = camera_matrix(camera, focal), np.array(camera.distortion)
    for _ in range(MAX_UNDISTORT):
        rays = np.concatenate([slopes.reshape(-1, 2), np.ones((slopes[..., 0].size, 1))], 1)
        missed = pixels - cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, lens)[0].reshape(pixels.shape)
        slopes = np.asarray(slopes + missed / focal, float)
        if np.abs(missed).max() < UNDISTORT_PX:
            return np.asarray(slopes)
    raise RenderError(
        f"camera.distortion = {list(camera.distortion)} is not allowed: it folds the image of {camera.columns} x "
        f"{camera.rows} pixels with a focal length of {focal:.0f} px"
    )


def principal_px(camera: Camera) -> Array:
    """Column and row at which the optical axis meets the image, shape (2,) [px]."""
    centre = (np.array([camera.columns, camera.rows]) - 1) / 2
    return np.asarray(centre + camera.principal_offset_px)


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
    slopes = window.of(pixel_slopes(camera, focal))
    return CameraCalibration(
        image_size=(window.columns, window.rows),
        camera_matrix=tuple(tuple(row) for row in matrix.tolist()),
        distortion=camera.distortion,
        pinhole_z_mm=face + camera.distance_mm,
        lens_face_z_mm=face,
        ior=design.materials.body.ior,
        layers=tuple(_layer(name, z, slopes, design, lens, camera) for name, z in _planes(design)),
    )


def _planes(design: ElastomerDesign) -> list[tuple[str, float]]:
    grid = resolve_grid(design)
    printed = grid.planes_mm(2).tolist() if grid is not None else []
    between = [(f"grid {number}", z) for number, z in enumerate(printed)]
    return [("contact face", 0.0), *between, ("bonded face", design.height_mm)]


def _layer(name: str, z_mm: float, slopes: Array, design: ElastomerDesign, lens: Lens, camera: Camera) -> LayerScale:
    row, column = np.unravel_index(np.square(slopes).sum(2).argmin(), slopes.shape[:2])
    rows, columns = (0, row, slopes.shape[0] // 2), (0, column, slopes.shape[1] // 2)
    along = _layer_landing_mm(slopes[rows, :], design, lens, camera, z_mm)
    beside = _layer_landing_mm(slopes[:, columns], design, lens, camera, z_mm).swapaxes(0, 1)
    across, down = (np.linalg.norm(np.diff(each, axis=1), axis=2) for each in (along, beside))
    width, height = (float(np.linalg.norm(each[2, -1] - each[2, 0])) for each in (along, beside))
    return LayerScale(
        name=name,
        z_mm=z_mm,
        mm_per_pixel=(float(across[1, : column + 1][-1]), float(down[1, : row + 1][-1])),
        mm_per_pixel_corner=(float(across[0, 0]), float(down[0, 0])),
        field_mm=(width, height),
    )
