"""Faces of a PLY file (Greg Turk, 1994) as triangles, where its reader would not take them or cut them wrongly."""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from magicsim.geometry.files.polygons import cut_polygons

TYPES = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
         "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d",
         "float64": "d", "int64": "q", "uint64": "Q", "float16": "e"}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
END = re.compile(rb"end_header[ \t]*\r?\n?")
INDICES = {"vertex_indices", "vertex_index"}
TRIANGLE = 3
Take = Callable[[str], tuple[Any, ...]]
"""Gives the next values, of the types that the letters of `struct` name."""


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

    None where the reader takes the file as it is.

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
