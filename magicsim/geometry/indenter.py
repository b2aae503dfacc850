"""A rigid object in a pose, as contact sees it, and how far it travels until it touches a curved face."""

from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import Dome, HeightMap
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.solids import Shape

COARSE_MM, FINE, LEAST = 0.25, 25, 8
"""Spacing of the places that are looked at first [mm], how much finer those are that follow, and how many of the first
there are at least across an object."""
CLOSE_MM = 1e-7
MOST_STEPS = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Indenter:
    """One solid in one pose."""

    shape: Shape
    pose: Pose

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance, (count,) [mm], and outward unit normal of points, (count, 3), in the sensor's frame."""
        distance, normal = self.shape.distance(self.pose.to_object(points))
        return distance, normal @ self.pose.rotation.T

    def box_mm(self) -> tuple[Array, Array]:
        """Lowest and highest coordinates of the object in the sensor's frame, shapes (3,) [mm]."""
        low, high = (
            np.array([sign * self.shape.support_mm(sign * axis) for axis in self.pose.rotation]) for sign in (-1, 1)
        )
        return self.pose.position_mm + low, self.pose.position_mm + high

    def top_mm(self) -> float:
        """Height of the object's highest point [mm]; negative below the undeformed contact face."""
        return float(self.pose.position_mm[2]) + self.shape.support_mm(self.pose.rotation[2])

    def depth_mm(self, face: Dome | HeightMap | None, footprint_mm: tuple[float, float]) -> float:
        """How deep it is pressed from where it first touches a face, as `place_object` has it [mm]; negative before."""
        top = self.top_mm()
        if face is None:
            return top
        level = replace(self.pose, position_mm=self.pose.position_mm - [0.0, 0.0, top])
        return top - first_touch_mm(self.shape, level, face, footprint_mm)

    def levels_mm(self) -> Array:
        """Heights from the undeformed contact face up to the highest point, one smallest feature apart [mm].

        What lies in the object above the face, however high, was passed by it on its way up: a ball pressed deeper than
        its diameter still touches. Empty when all of it is below the face.
        """
        top = max(0.0, self.top_mm())
        return np.linspace(0, top, int(np.ceil(top / self.shape.feature_mm)), endpoint=False)


def place_object(
    config: ObjectBase, *, gap_mm: float, x_mm: float = 0.0, y_mm: float = 0.0, twist_deg: float = 0.0,
    tilt_x_deg: float = 0.0, tilt_y_deg: float = 0.0, design: ElastomerDesign | None = None,
) -> Indenter:  # fmt: skip
    """Puts an object under the contact face.

    Args:
        config: Kind, size and orientation.
        gap_mm: Distance of its highest point from the undeformed contact face [mm]; negative when pressed. Below a
            curved face, its travel along z until it first touches.
        x_mm: Its origin along x [mm].
        y_mm: Its origin along y [mm].
        twist_deg: Rotation about the sensor's z axis, added to its own yaw [degrees].
        tilt_x_deg: Rotation vector applied after the twist: along the sensor's x [degrees].
        tilt_y_deg: Along its y [degrees].
        design: The block, where its face may be curved.

    Raises:
        ConfigError: It is pressed, and its size tells that it is given in another unit.
    """
    if gap_mm < 0:
        config.refuse_contact()
    shape: Shape = config.shape()
    turned = Pose.from_degrees(
        np.array([x_mm, y_mm, 0.0]), roll=config.roll_deg, pitch=config.pitch_deg, yaw=config.yaw_deg + twist_deg
    ).tilted((tilt_x_deg, tilt_y_deg))
    z_mm = -gap_mm - shape.support_mm(turned.rotation[2])
    if design is not None and design.face is not None:
        level = Pose(position_mm=np.array([x_mm, y_mm, z_mm + gap_mm]), rotation=turned.rotation)
        z_mm += first_touch_mm(shape, level, design.face, design.footprint_mm)
    return Indenter(shape=shape, pose=Pose(position_mm=np.array([x_mm, y_mm, z_mm]), rotation=turned.rotation))


def first_touch_mm(shape: Shape, pose: Pose, face: Dome | HeightMap, footprint_mm: tuple[float, float]) -> float:
    """Travel along z until an object touches a curved face, from a pose with its highest point at z = 0 [mm].

    Conservative advancement: an object whose nearest place of the face is at distance d may rise by d, and one that a
    place is found in by so much has to sink. One that passes beside the block touches nothing; it counts from the
    highest place of the face. The travel is never negative.
    """
    half = np.array(footprint_mm) / 2
    axes = [np.linspace(-size / 2, size / 2, round(size / COARSE_MM) + 1) for size in footprint_mm]
    places = np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
    highest = float(face.rise_mm(places).max())
    low, high = (np.clip(each[:2], -half, half) for each in Indenter(shape=shape, pose=pose).box_mm())
    if (high - low).min() < LEAST * COARSE_MM:
        counts = np.maximum(np.ceil((high - low) / COARSE_MM), LEAST).astype(int) + 1
        axes = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
        places = np.concatenate([places, np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)])
    travel, nearest = _advance(shape, pose, face, places, 0.0, highest)
    local = np.linspace(-COARSE_MM, COARSE_MM, 2 * FINE + 1)
    fine = nearest + np.stack(np.meshgrid(local, local), -1).reshape(-1, 2)
    return _advance(shape, pose, face, np.clip(fine, -half, half), max(0.0, travel - COARSE_MM), highest)[0]


def _advance(
    shape: Shape, pose: Pose, face: Dome | HeightMap, places: Array, start: float, most: float
) -> tuple[float, Array]:
    points = np.column_stack([places, face.rise_mm(places)])
    travel, nearest = start, places[0]
    for _ in range(MOST_STEPS):
        distances = shape.distance(pose.to_object(points - [0.0, 0.0, travel]))[0]
        number = int(distances.argmin())
        nearest, distance = places[number], float(distances[number])
        if abs(distance) < CLOSE_MM or (travel >= most if distance > 0 else travel <= 0):
            break
        travel = max(0.0, travel + distance)
    return min(travel, most), nearest
