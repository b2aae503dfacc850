"""How far an object travels along z from the crown's plane until it first touches a curved face."""

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.face_shape import Dome, HeightMap
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.solids import Shape

COARSE_MM, FINE = 0.25, 25
"""Spacing of the places that are looked at first [mm], and how much finer those are that follow."""
CLOSE_MM = 1e-7
MOST_STEPS = 200


def first_touch_mm(shape: Shape, pose: Pose, face: Dome | HeightMap, footprint_mm: tuple[float, float]) -> float:
    """Travel along z until the object touches, from where its highest point is at z = 0; never negative [mm].

    Conservative advancement: an object whose nearest place of the face is at distance d may rise by d. One that passes
    beside the block touches nothing; it counts from the highest place of the face.

    Args:
        shape: The object.
        pose: With its highest point at z = 0.
        face: Shape of the contact face.
        footprint_mm: Of the block [mm].
    """
    axes = [np.linspace(-size / 2, size / 2, round(size / COARSE_MM) + 1) for size in footprint_mm]
    places = np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
    highest = float(face.rise_mm(places).max())
    travel, nearest = _advance(shape, pose, face, places, 0.0, highest)
    local = np.linspace(-COARSE_MM, COARSE_MM, 2 * FINE + 1)
    fine = nearest + np.stack(np.meshgrid(local, local), -1).reshape(-1, 2)
    half = np.array(footprint_mm) / 2
    return _advance(shape, pose, face, np.clip(fine, -half, half), max(0.0, travel - COARSE_MM), highest)[0]


def _advance(
    shape: Shape, pose: Pose, face: Dome | HeightMap, places: Array, start: float, most: float
) -> tuple[float, Array]:
    points = np.column_stack([places, face.rise_mm(places)])
    travel, nearest = start, places[0]
    for _ in range(MOST_STEPS):
        distance = shape.distance(pose.to_object(points - [0.0, 0.0, travel]))[0]
        number = int(distance.argmin())
        nearest = places[number]
        if distance[number] < CLOSE_MM or travel >= most:
            break
        travel += float(distance[number])
    return min(travel, most), nearest
