"""What the first bytes of a mesh file promise, so that a broken or huge one is refused before it is read.

STL: 80 bytes, the number of triangles, 50 bytes each; or text (Marshall Burns, Automated Fabrication, 1993). PLY: a
text header with the numbers of vertices and faces (Greg Turk, 1994). GLB: chunks of given length, the first one JSON
(glTF 2.0, section 4.4).
"""

import mmap
import re
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from magicsim.config.documents import parse_json

MAX_TRIANGLES = 500_000
MAX_BYTES = 200_000_000
"""Largest file: text with so many triangles has about 130 MB."""
_STL_HEAD, _STL_TRIANGLE = 84, 50
_PLY_HEAD = 1 << 16
_PLY_VERTEX, _PLY_FACE = 3, 4
"""Fewest bytes of a vertex and of a face."""
_GLB_HEAD = 20
_GLB_JSON = 16_000_000
"""Longest JSON of a GLB file [bytes]."""
_GLB_VALUES = 3 * MAX_TRIANGLES
"""Most values of one kind in a GLB file."""


def header_problem(path: Path) -> str | None:
    """Why a mesh file cannot be read, by its size and its header; None where nothing speaks against it.

    Args:
        path: An STL, OBJ, PLY or GLB file.

    Raises:
        OSError: It cannot be opened.
    """
    size = path.stat().st_size
    if size == 0:
        return "is empty: it has no triangles"
    if size > MAX_BYTES:
        return f"has {size / 1e6:.0f} MB: at most {MAX_BYTES / 1e6:.0f} MB are allowed"
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return _PROBLEMS[path.suffix.lower()](content)


def _too_many(count: int) -> str | None:
    return f"has {count} triangles: at most {MAX_TRIANGLES} are allowed" if count > MAX_TRIANGLES else None


def _stl(content: mmap.mmap) -> str | None:
    size = len(content)
    count = int.from_bytes(content[_STL_HEAD - 4 : _STL_HEAD], "little") if size >= _STL_HEAD else 0
    if size == _STL_HEAD + _STL_TRIANGLE * count and size >= _STL_HEAD:
        return _too_many(count) if count else "is empty: it has no triangles"
    start = content[:1024]
    if start.lstrip()[:5].lower() == b"solid" and (b"facet" in start or b"endsolid" in start):
        if b"\0" in start:
            return "cannot be read: it begins as a text STL and holds bytes that are no text"
        return _too_many_matches(content, rb"endfacet")
    if size < _STL_HEAD:
        return f"cannot be read: its {size} bytes are neither a binary nor a text STL"
    expected = _STL_HEAD + _STL_TRIANGLE * count
    return (
        f"cannot be read: it is no text STL, and a binary one of the {count} triangles in its header has {expected} "
        f"bytes; this one has {size}"
    )


def _obj(content: mmap.mmap) -> str | None:
    if content.find(b"\0") >= 0:
        return "cannot be read: it holds bytes that are no text"
    return _too_many_matches(content, rb"(?m)^[ \t]*f\s")


def _ply(content: mmap.mmap) -> str | None:
    end = content.find(b"end_header", 0, _PLY_HEAD)
    if content[:3] != b"ply" or end < 0:
        return "cannot be read: it does not begin with a PLY header"
    counts = {kind: int(number) for kind, number in re.findall(rb"element\s+(\w+)\s+(\d{1,18})\s", content[:end])}
    vertices, faces = counts.get(b"vertex", 0), counts.get(b"face", 0)
    if vertices > 3 * MAX_TRIANGLES:
        return f"has {vertices} vertices: at most {3 * MAX_TRIANGLES} are allowed"
    if end + _PLY_VERTEX * vertices + _PLY_FACE * faces > len(content):
        return (
            f"cannot be read: its header promises {vertices} vertices and {faces} faces, more than its {len(content)} "
            "bytes can hold"
        )
    return _too_many(faces) if faces else "is empty: it has no triangles"


def _glb(content: mmap.mmap) -> str | None:
    size = len(content)
    if content[:4] != b"glTF" or size < _GLB_HEAD:
        return "cannot be read: it does not begin with a GLB header"
    version, length, chunk = (int.from_bytes(content[begin : begin + 4], "little") for begin in (4, 8, 12))
    if version != 2:  # noqa: PLR2004 - glTF 2.0
        return f"cannot be read: it is glTF {version}, must be 2"
    if length != size or chunk > size - _GLB_HEAD:
        return f"cannot be read: its header promises {max(length, chunk + _GLB_HEAD)} bytes, and it has {size}"
    if chunk > _GLB_JSON or content[16:20] != b"JSON":
        return "cannot be read: it does not begin with a JSON chunk of up to 16 MB"
    return _glb_tree(content[_GLB_HEAD : _GLB_HEAD + chunk])


def _glb_tree(chunk: bytes) -> str | None:
    try:
        tree = parse_json(chunk.decode(), source="its JSON")
        most = max((int(each["count"]) for each in tree.get("accessors", ())), default=0)
        total = sum(_glb_triangles(tree))
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
        return f"cannot be read: {error if isinstance(error, ValueError) else 'its JSON is no glTF'}"
    if most > _GLB_VALUES:
        return f"has {most} values of one kind: at most {_GLB_VALUES} are allowed"
    return _too_many(total)


def _glb_triangles(tree: dict[str, Any]) -> Iterator[int]:
    """Triangles of each mesh, as often as nodes show it."""
    shown = [each["mesh"] for each in tree.get("nodes", ()) if "mesh" in each]
    for number in shown:
        for part in tree["meshes"][number]["primitives"]:
            corners = part["indices"] if "indices" in part else part["attributes"]["POSITION"]
            yield int(tree["accessors"][corners]["count"]) // 3


def _too_many_matches(content: mmap.mmap, triangle: bytes) -> str | None:
    is_too_many = next(islice(re.finditer(triangle, content), MAX_TRIANGLES, None), None) is not None
    return f"has more triangles than the {MAX_TRIANGLES} that are allowed" if is_too_many else None


_PROBLEMS: dict[str, Callable[[mmap.mmap], str | None]] = {".stl": _stl, ".obj": _obj, ".ply": _ply, ".glb": _glb}
