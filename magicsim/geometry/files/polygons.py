"""Polygons of OBJ and OFF files: readers cut every polygon into a fan, which covers other ground than a concave one."""

import re
from collections import defaultdict
from collections.abc import Sequence

import manifold3d
import numpy as np

from magicsim.arrays import Array

JOINED = re.compile(r"\\\r?\n")
FEWEST = 4
"""Corners from which a fan can be wrong."""
TURN = 1e-9
"""Part of a polygon's area by which a corner has to turn the other way to count, and that a triangle of a fan needs."""
OFF_HEADER = re.compile(r"\s*(?:ST)?(C?)(N?)(4?)(n?)OFF\b(\s+BINARY\b)?")
"""Colours, normals, a fourth coordinate and dimension of vertices (Geomview manual, OFF)."""
Triangles = list[list[int]]


def triangulated_obj(content: bytes) -> bytes | None:
    """The text with triangles for polygons that a fan does not cover, and no number below 0; None where it is the same.

    Corners keep what they name (vertex, texture, normal), and lines their order.

    `ValueError` where a number cannot be read, or a face names a vertex that is not there.
    """
    lines = JOINED.sub("", content.decode("utf-8", errors="replace")).splitlines()
    vertices: list[list[float]] = []
    counts, polygons, is_changed = {"v": 0, "vt": 0, "vn": 0}, {}, False
    for number, line in enumerate(lines):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] in counts:
            counts[words[0]] += 1
        if words[0] == "v":
            vertices.append([float(each) for each in words[1:4]])
        elif words[0] == "f" and "-" in line:  # readers count from the end of the file, and not from there
            words = ["f", *(_counted(each, tuple(counts.values())) for each in words[1:])]
            lines[number], is_changed = " ".join(words), True
        if words[0] == "f" and len(words) > FEWEST:
            polygons[number] = [int(each.split("/")[0]) - 1 for each in words[1:]]
    numbers, cuts = list(polygons), cut_polygons(np.array(vertices), list(polygons.values()))
    for index, triangles in cuts.items():
        words = lines[numbers[index]].split("#")[0].split()[1:]
        lines[numbers[index]] = "\n".join("f " + " ".join(words[corner] for corner in each) for each in triangles)
    return ("\n".join(lines) + "\n").encode() if cuts or is_changed else None


def _counted(corner: str, counts: tuple[int, ...]) -> str:
    """Vertex, texture and normal of a corner, those below 0 counted from the begin of the file instead."""
    numbers = zip(corner.split("/"), counts, strict=False)
    return "/".join(str(count + 1 + int(each)) if each.startswith("-") else each for each, count in numbers)


def off_as_obj(content: bytes) -> bytes:
    """Vertices and faces of an OFF file as the text of an OBJ file; colours and normals are left out.

    `ValueError` where it is no text in three dimensions, or ends early.
    """
    text = re.sub(r"#.*", "", content.decode("utf-8", errors="replace"))
    header = OFF_HEADER.match(text)
    if header is None or header[3] or header[4] or header[5]:
        raise ValueError("it does not begin with the header of a text OFF in three dimensions")
    lines = [words for each in text[header.end() :].splitlines() if (words := each.split())]
    vertices, faces = (int(each) for each in [*(lines or [[]])[0], "-1", "-1"][:2])
    if vertices < 0 or faces < 0 or len(lines) <= vertices + faces:
        raise ValueError(
            f"its header promises {vertices} vertices and {faces} faces, and it has {len(lines) - 1} lines"
        )
    rows = [f"v {' '.join(each[:3])}" for each in lines[1 : vertices + 1]]
    for corners in lines[vertices + 1 : vertices + faces + 1]:
        count = int(corners[0])
        if count >= FEWEST - 1:  # others are points and lines
            rows.append("f " + " ".join(str(int(each) + 1) for each in corners[1 : count + 1]))
    return "\n".join(rows).encode()


def cut_polygons(points: Array, polygons: Sequence[Sequence[int]]) -> dict[int, Triangles]:
    """Triangles of the polygons that a fan from their first corner does not cover, by their numbers.

    Triangles name corners as counted along their polygon. Points have the shape (points, 3).
    """
    groups: dict[int, list[int]] = defaultdict(list)
    for number, polygon in enumerate(polygons):
        groups[len(polygon)].append(number)
    cuts = {}
    for size, group in groups.items():
        corners = np.array([polygons[number] for number in group])
        if size > 0 and (corners.min() < 0 or corners.max() >= len(points)):
            raise ValueError("a face names a vertex that is not there")
        if size < FEWEST:
            continue
        for index in np.flatnonzero(_needs_cuts(points[corners])):
            cuts[group[index]] = _triangles(points[corners[index]])
    return dict(sorted(cuts.items()))


def _needs_cuts(corners: Array) -> Array:
    """Whether polygons turn both ways or a triangle of their fan is flat; `corners`: (polygons, corners, 3)."""
    local = corners - corners.mean(1, keepdims=True)
    normal = np.cross(local, np.roll(local, -1, 1)).sum(1)
    side, least = np.roll(local, -1, 1) - local, TURN * np.einsum("pi,pi->p", normal, normal)
    turn = np.einsum("pci,pi->pc", np.cross(side, np.roll(side, -1, 1)), normal)
    spokes = local[:, 1:] - local[:, :1]
    fan = np.einsum("pci,pi->pc", np.cross(spokes[:, :-1], spokes[:, 1:]), normal)
    is_flat = (fan.min(1) <= least) & (least > 0) & side.any(2).all(1)
    return np.asarray((turn.min(1) < -least) | is_flat)


def _triangles(corners: Array) -> Triangles:
    """Triangles of a polygon in its own plane, counted as its corners and turning as it does."""
    local = corners - corners.mean(0)
    normal = np.cross(local, np.roll(local, -1, 0)).sum(0)
    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    plane = np.stack([across, np.cross(normal, across)])
    plane /= np.linalg.norm(plane, axis=1, keepdims=True)
    return [[int(corner) for corner in each] for each in manifold3d.triangulate([local @ plane.T])]
