"""The hand that brings an item and pulls at it, as both fingers see it: it touches nothing in the mechanics.

It comes from the front, as a person's does: the thumb on one side of the item, fingers on the other, so that the faces
that the gripper closes on stay free. Sizes are those of an adult's hand, assumed, as its colour is.
"""

from itertools import pairwise

import numpy as np
from manifold3d import Manifold

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import ObjectPlace, object_pose

SKIN = (0.48, 0.29, 0.20)
"""Diffuse reflectance in linear RGB; assumed: medium skin."""
FINGER_MM = 8.0
"""Radius of a finger [mm]."""
FEWEST, MOST = 2, 4
"""Fingers beside the thumb: as many as are no higher than the item, between these."""
CLEAR_MM = 2.2
"""How far below the item's faces it stays on both sides, more than any face is pressed in [mm]."""
THINNEST_MM = 0.25
"""Least radius of a finger, on items that leave no room for more [mm]."""
BALL = 12
"""Segments of the balls that it is made of."""
FACET_MM = 12.0
"""Longest edge of triangles, each of which has a brightness of its own [mm]."""
WAY_MM = 140.0
"""From where, in front of where it holds the item, a hand comes and is gone again [mm]."""

Ball = tuple[float, float, float, float]


def hand_mesh(item: AnyObject) -> SurfaceMesh:
    """A hand that holds an item, with its colour, in the gripper's axes about the item's origin."""
    rotation, shape = object_pose(item, ObjectPlace()).rotation, item.shape()
    (right, left), (front, _), (up, down) = ((shape.support_mm(each), shape.support_mm(-each)) for each in rotation)
    middle, room = (up - down) / 2, (up + down) / 2 - CLEAR_MM
    count = int(np.clip(room // FINGER_MM, FEWEST, MOST))
    radius = max(THINNEST_MM, min(FINGER_MM, room / count))
    heights = [middle + radius * (2 * number - count + 1) for number in range(count)]
    size, side, other = radius / FINGER_MM, right + radius, left + radius
    wrist: Ball = (0.0, front + 85 * size, middle, min(2.4, count) * radius)
    parts = [_hull(wrist, (0.0, front + 170 * size, middle, min(2.6, count) * radius))]
    corners = [shape.support_mm((rotation[1] + sign * rotation[0]) / np.sqrt(2)) for sign in (1, -1)]
    bends = [np.sqrt(2) * (corner + radius) - way for corner, way in zip(corners, (side, other), strict=True)]
    ball: Ball = (-0.8 * left, front + 1.6 * radius, middle, 1.5 * radius)
    for z in heights:
        knuckle: Ball = (0.8 * side, front + 1.05 * radius, z, radius)
        finger = (
            knuckle, (side + 0.2 * radius, bends[0], z, radius), (side, 0.1 * front, z, radius),
            (side - 0.1 * radius, -0.4 * front, z, 0.85 * radius),
        )  # fmt: skip
        parts += [_hull(knuckle, ball, wrist), *(_hull(*pair) for pair in pairwise(finger))]
    thumb = (ball, (-other - 0.2 * radius, bends[1], middle, 1.1 * radius), (-other, -0.2 * front, middle, radius))
    parts += [_hull(*pair) for pair in pairwise(thumb)]
    return colored(sum(parts[1:], parts[0]).simplify(0.05), SKIN)


def colored(solid: Manifold, color: tuple[float, float, float]) -> SurfaceMesh:
    """A solid of one colour, diffuse reflectance in linear RGB, in facets no longer than `FACET_MM`."""
    mesh = from_manifold(solid.refine_to_length(FACET_MM))
    return SurfaceMesh(vertices=mesh.vertices, faces=mesh.faces, colors=np.tile(color, (len(mesh.vertices), 1)))


def hand_pose(place: ObjectPlace, away_mm: float) -> Pose:
    """A hand in the gripper's frame, so far in front of where it holds an item [mm]."""
    position = np.array([place.x_mm, place.y_mm + away_mm, place.z_mm])
    return Pose.from_degrees(position, yaw=place.twist_deg)


def _hull(*balls: Ball) -> Manifold:
    """The convex hull of balls: place and radius each [mm]."""
    ends: list[Array] = [
        np.asarray(Manifold.sphere(radius, BALL).translate((x, y, z)).to_mesh64().vert_properties[:, :3])
        for x, y, z, radius in balls
    ]
    return Manifold.hull_points(np.concatenate(ends))
