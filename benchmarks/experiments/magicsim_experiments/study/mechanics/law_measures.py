"""What a plane field of displacements says: how large, how wide, which way, and which way round."""

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Mask

MOVED_SHARE = 0.2
"""Part of the largest displacement from which a place counts as moved."""


def extent_mm(places_mm: Array, moved_mm: Array, *, least_mm: float) -> float:
    """Radius of the circle whose area is that of the places that moved by so much [mm].

    Args:
        places_mm: Evenly spaced, shape (places, 2) [mm].
        moved_mm: Length of each displacement, shape (places,) [mm].
        least_mm: Least length that counts [mm].
    """
    axes = [np.unique(np.round(places_mm[:, axis], 6)) for axis in (0, 1)]
    area = float(np.prod([np.ptp(axis) / max(len(axis) - 1, 1) for axis in axes]))
    return float(np.sqrt((moved_mm >= least_mm).sum() * area / np.pi))


def direction_deg(moved: Array) -> float:
    """Direction of the sum of displacements, from x towards y [degrees].

    Args:
        moved: Shape (places, 2), in any unit.
    """
    x, y = moved.sum(0)
    return float(np.degrees(np.arctan2(y, x)))


def turn_deg(places: Array, moved: Array) -> float:
    """Turn about the origin that is nearest to displacements in the mean square, from x towards y [degrees].

    Args:
        places: Shape (places, 2).
        moved: In the unit of the places, shape (places, 2).
    """
    x, y = places.T
    return float(np.degrees((x * moved[:, 1] - y * moved[:, 0]).sum() / max((x * x + y * y).sum(), 1e-12)))


def moved_places(moved: Array) -> Mask:
    """Which places moved by at least `MOVED_SHARE` of the largest displacement, shape (places,)."""
    length = np.linalg.norm(moved, axis=1)
    return np.asarray(length >= MOVED_SHARE * length.max())


def angle_between_deg(found: float, true: float) -> float:
    """Found less true angle, in -180 to 180 [degrees]."""
    return (found - true + 180.0) % 360.0 - 180.0


def optical_flow_px(before: npt.NDArray[np.uint8], after: npt.NDArray[np.uint8]) -> Array:
    """Dense flow of one image to another by dense inverse search, shape (rows, columns, 2): right and down [px].

    Args:
        before: RGB, shape (rows, columns, 3).
        after: RGB, of the same shape.
    """
    grey = [cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in (before, after)]
    search = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)  # type: ignore[attr-defined]
    return np.asarray(search.calc(grey[0], grey[1], None), np.float64)
