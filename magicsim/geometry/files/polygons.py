"""Polygons of OBJ, OFF and PLY files as triangles: a reader's fan covers other ground than a concave polygon."""

import re
import struct
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

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
TYPES = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
         "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d",
         "float64": "d", "int64": "q", "uint64": "Q", "float16": "e"}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
END = re.compile(rb"end_header[ \t]*\r?\n?")
INDICES = {"vertex_indices", "vertex_index"}
TRIANGLE = 3
Take = Callable[[str], tuple[Any, ...]]
"""Gives the next values, of the types that the letters of `struct` name."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """One kind of a file's elements: how many there are, and names and types of their properties."""

    name: str
    count: int
    scalars: dict[str, str]
    lists: dict[str, tuple[str, str]]
    """Types of the length and of the values."""
    order: list[str]

    def read(self, take: Take) -> tuple[list[list[Any]], dict[str, list[tuple[Any, ...]]]]:
        """Numbers of all elements, and their lists by name."""
        if not self.lists:
            letters = "".join(self.scalars.values())
            return [list(take(letters)) for _ in range(self.count)], {}
        rows: list[list[Any]] = []
        lists: dict[str, list[tuple[Any, ...]]] = {name: [] for name in self.lists}
        for _ in range(self.count):
            row: list[Any] = []
            for name in self.order:
                if name in self.scalars:
                    row += take(self.scalars[name])
                else:
                    length, kind = self.lists[name]
                    lists[name].append(take(kind * int(take(length)[0])))
            rows.append(row)
        return rows, lists


def triangulated_ply(content: bytes) -> bytes | None:
    """Vertices and triangles, where polygons are concave or coloured, or differ in size in a binary file.

    None where the reader takes the file as it is; `ValueError` where it is broken.
    """
    end = END.search(content)
    header = content[: end.start() if end else 0].decode("ascii", errors="replace").splitlines()
    order = next((words[1] for line in header if (words := line.split())[:1] == ["format"]), "")
    if end is None or order not in ORDERS:
        return None
    take, found = _taker(content[end.end() :], ORDERS[order]), {}
    for each in _elements(header):
        found[each.name] = each, *each.read(take)
        if each.name == "face":
            break
    if not {"vertex", "face"} <= found.keys() or not (name := next(iter(INDICES & found["face"][2].keys()), "")):
        return None
    (vertex, corners, _), (face, numbers, lists) = found["vertex"], found["face"]
    polygons = [[int(each) for each in polygon] for polygon in lists[name]]
    sizes = {len(each) for each in polygons}
    places = [list(vertex.scalars).index(axis) for axis in "xyz"]
    cuts = cut_polygons(np.array(corners, np.float64)[:, places], polygons)
    if sizes <= {TRIANGLE} or (not cuts and not face.scalars and (order == "ascii" or len(sizes) == 1)):
        return None
    triangles, colours = [], []
    for number, polygon in enumerate(polygons):
        fan = cuts.get(number) or [[0, each, each + 1] for each in range(1, len(polygon) - 1)]
        triangles += [[polygon[corner] for corner in each] for each in fan]
        colours += [numbers[number]] * len(fan)
    lines = ["ply", "format binary_little_endian 1.0", *(line for line in header if line.startswith("comment"))]
    lines += [f"element vertex {len(corners)}", *_declared(vertex), f"element face {len(triangles)}"]
    lines += ["property list uchar uint vertex_indices", *_declared(face), "end_header\n"]
    record = struct.Struct("<B3I" + "".join(face.scalars.values()))
    point = struct.Struct("<" + "".join(vertex.scalars.values()))
    body = [point.pack(*_typed(vertex, row)) for row in corners]
    body += [record.pack(3, *each, *_typed(face, row)) for each, row in zip(triangles, colours, strict=True)]
    return "\n".join(lines).encode() + b"".join(body)


def _elements(header: list[str]) -> list[Element]:
    elements: list[Element] = []
    for words in (line.split() for line in header):
        if words[:1] == ["element"]:
            elements.append(Element(name=words[1], count=int(words[2]), scalars={}, lists={}, order=[]))
        elif words[:1] == ["property"]:
            if words[1] == "list":
                elements[-1].lists[words[-1]] = TYPES[words[2]], TYPES[words[3]]
            else:
                elements[-1].scalars[words[-1]] = TYPES[words[1]]
            elements[-1].order.append(words[-1])
    return elements


def _taker(body: bytes, order: str) -> Take:
    """Reads text or binary values in their order."""
    words, position = (word for line in body.splitlines() for word in line.split()), 0

    def text(letters: str) -> tuple[Any, ...]:
        values = tuple(float(each) for each in islice(words, len(letters)))
        return values if len(values) == len(letters) else _ends_early()

    def binary(letters: str) -> tuple[Any, ...]:
        nonlocal position
        begin, position = position, position + struct.calcsize(order + letters)
        return struct.unpack_from(order + letters, body, begin) if position <= len(body) else _ends_early()

    return binary if order else text


def _ends_early() -> tuple[Any, ...]:
    raise ValueError("it ends before the elements that its header promises")


def _declared(element: Element) -> list[str]:
    names = {letter: name for name, letter in reversed(TYPES.items())}
    return [f"property {names[letter]} {name}" for name, letter in element.scalars.items()]


def _typed(element: Element, row: list[Any]) -> list[Any]:
    """Values as `struct` packs them: text has floating-point numbers only."""
    return [each if letter in "fd" else int(each) for each, letter in zip(row, element.scalars.values(), strict=True)]
