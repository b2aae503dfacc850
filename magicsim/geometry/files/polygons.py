"""Concave polygons of OBJ files: readers cut every polygon into a fan, which covers other ground than a concave one."""

import re
from collections import defaultdict

import manifold3d
import numpy as np

from magicsim.arrays import Array

JOINED = re.compile(r"\\\r?\n")
FEWEST = 4
"""Corners from which a polygon can be concave."""
TURN = 1e-9
"""Part of a polygon's area by which a corner has to turn the other way to count."""


def triangulated_obj(content: bytes) -> bytes | None:
    """The text with triangles in place of every concave polygon; None where all are convex.

    Corners keep what they name (vertex, texture, normal), and lines their order.

    Raises:
        ValueError: A number cannot be read, or a face names a vertex that is not there.
    """
    lines = JOINED.sub("", content.decode("utf-8", errors="replace")).splitlines()
    vertices: list[list[float]] = []
    polygons: dict[int, list[tuple[int, list[int]]]] = defaultdict(list)
    for number, line in enumerate(lines):
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            vertices.append([float(each) for each in words[1:4]])
        elif words[:1] == ["f"] and len(words) > FEWEST:
            named = [int(each.split("/")[0]) for each in words[1:]]
            polygons[len(named)].append((number, [each - 1 if each > 0 else len(vertices) + each for each in named]))
    if not polygons:
        return None
    points, is_changed = np.array(vertices), False
    for group in polygons.values():
        corners = np.array([corners for _, corners in group])
        if corners.min() < 0 or corners.max() >= len(points):
            raise ValueError("a face names a vertex that is not there")
        for index in np.flatnonzero(_is_concave(points[corners])):
            number = group[index][0]
            words = lines[number].split("#")[0].split()[1:]
            triangles = _triangles(points[corners[index]])
            lines[number] = "\n".join("f " + " ".join(words[corner] for corner in each) for each in triangles)
            is_changed = True
    return ("\n".join(lines) + "\n").encode() if is_changed else None


def _is_concave(corners: Array) -> Array:
    """Whether polygons turn both ways, shape (polygons,); `corners` has the shape (polygons, corners, 3)."""
    local = corners - corners.mean(1, keepdims=True)
    normal = np.cross(local, np.roll(local, -1, 1)).sum(1)
    side = np.roll(local, -1, 1) - local
    turn = np.einsum("pci,pi->pc", np.cross(side, np.roll(side, -1, 1)), normal)
    return np.asarray(turn.min(1) < -TURN * np.einsum("pi,pi->p", normal, normal))


def _triangles(corners: Array) -> list[list[int]]:
    """Triangles of a polygon in its own plane, counted as its corners and turning as it does."""
    local = corners - corners.mean(0)
    normal = np.cross(local, np.roll(local, -1, 0)).sum(0)
    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    plane = np.stack([across, np.cross(normal, across)])
    plane /= np.linalg.norm(plane, axis=1, keepdims=True)
    return [[int(corner) for corner in each] for each in manifold3d.triangulate([local @ plane.T])]
