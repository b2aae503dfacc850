"""Reads the mesh of an object from a file, and refuses what cannot press."""

import atexit
import logging
import mmap
import re
from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

import igl
import numpy as np
import numpy.typing as npt
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from magicsim.config.documents import parse_json
from magicsim.config.presets import PATHS_START, is_file
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.shapes.mesh_solid import MeshShape

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


JITTER = 1e-9
"""Random motion of the vertices, in units of the mesh's size: faces that lie in one plane then cross, or do not."""


def crossing_edges(surface: SurfaceMesh) -> int:
    """How many edges pass through a triangle that they do not touch; 0 where the surface keeps clear of itself.

    Two triangles that cross have an edge of one in the other, so that none is missed. Surfaces that merely touch may
    count as well.
    """
    size = float(np.ptp(surface.vertices, axis=0).max())
    moved = surface.vertices + JITTER * size * np.random.default_rng(0).uniform(-1, 1, surface.vertices.shape)
    faces = surface.faces.astype(np.int64)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    tree = igl.AABB()
    tree.init(moved, faces)
    begin = np.ascontiguousarray(moved[edges[:, 0]])
    along = np.ascontiguousarray(moved[edges[:, 1]] - begin)
    hits = [
        (edge, hit[0]) for edge, found in enumerate(tree.intersect_ray(moved, faces, begin, along)) for hit in found
        if 0 < hit[1] < 1
    ]  # fmt: skip
    if not hits:
        return 0
    edge, face = np.array(hits).T
    touches = (edges[edge][:, :, None] == faces[face][:, None, :]).any(axis=(1, 2))
    return len(np.unique(edge[~touches]))


def inside_out_parts(surface: SurfaceMesh) -> int:
    """How many of the parts that do not hang together are inside out, cavities in other parts left out."""
    faces, count = surface.faces, len(surface.vertices)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(ends), bool), (ends[:, 0], ends[:, 1])), shape=(count, count))
    parts, part_of = connected_components(graph, directed=False)
    a, b, c = (surface.vertices[faces[:, corner]] for corner in range(3))
    volumes = np.zeros(parts)
    np.add.at(volumes, part_of[faces[:, 0]], np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)
    low, high = np.full((parts, 3), np.inf), np.full((parts, 3), -np.inf)
    np.minimum.at(low, part_of, surface.vertices)
    np.maximum.at(high, part_of, surface.vertices)
    solid, inverted = np.flatnonzero(volumes > 0), np.flatnonzero(volumes < 0)
    return sum(not ((low[solid] < low[each]) & (high[each] < high[solid])).all(axis=1).any() for each in inverted)


OBJ_OPTIONS: dict[str, Any] = {"skip_materials": True}
"""Textures are read where colours are asked for."""
LOGGER = logging.getLogger(__name__)
logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # what it stumbles on is told once, by us
SUFFIXES = (".stl", ".obj", ".ply", ".glb")
MIN_SIZE_MM, MAX_SIZE_MM = 0.01, 200.0
"""Least and largest extent of a mesh [mm]."""
MAX_PLACE_MM = 10_000.0
"""Farthest from its origin that a mesh may lie [mm]: files hold single precision."""


def load_mesh(path: str, *, scale: float = 1.0, feature_mm: float | None = None) -> MeshShape:
    """Reads an STL, OBJ, PLY or GLB file; one unit of the file times `scale` is a millimetre.

    The last few files are kept, as long as they do not change. A surface that passes through itself is warned about:
    contact is that of its outside, which is the same as if its parts were one.

    Raises:
        ConfigError: No such file, not readable as a mesh, empty, not watertight, too small, too large or too detailed.
    """
    file = Path(path)
    if file.suffix.lower() not in SUFFIXES:
        msg = f"mesh '{path}' is not allowed: must end in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise ConfigError(msg)
    if not is_file(file):
        msg = f"mesh '{path}' does not exist ({PATHS_START})"
        raise ConfigError(msg)
    return _load(path, scale, feature_mm, file.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _load(path: str, scale: float, feature_mm: float | None, _stamp: int) -> MeshShape:
    try:
        problem = header_problem(Path(path))
        if problem is not None:
            msg = f"mesh '{path}' {problem}"
            raise ConfigError(msg)
        loaded = trimesh.load_mesh(path, process=False, **OBJ_OPTIONS if path.lower().endswith(".obj") else {})
        _check_vertices(path, np.asarray(loaded.vertices, np.float64)[np.unique(loaded.faces)] * scale)
        mesh = trimesh.Trimesh(loaded.vertices, loaded.faces, process=True)
        mesh = trimesh.Trimesh(np.asarray(mesh.vertices) * scale, mesh.faces, process=True)
    except ConfigError:
        raise
    except Exception as error:  # the readers raise whatever they stumble on
        reason = str(error).partition("\n")[0] or type(error).__name__
        msg = f"mesh '{path}' cannot be read: {reason}"
        raise ConfigError(msg) from None
    _check(path, mesh)
    if mesh.volume < 0:
        mesh.invert()
    surface = SurfaceMesh(vertices=np.array(mesh.vertices, dtype=np.float64), faces=np.array(mesh.faces, np.int32))
    if inverted := inside_out_parts(surface):
        msg = f"mesh '{path}' has parts that are inside out ({inverted} of them): turn their normals outwards"
        raise ConfigError(msg)
    crossing = crossing_edges(surface)
    if crossing:
        LOGGER.warning(
            "mesh '%s' passes through itself: %d of its edges cross other triangles; contact is that of its outside",
            path,
            crossing,
        )
    return MeshShape.of(surface, feature_mm=feature_mm)


def _check_vertices(path: str, vertices_mm: npt.NDArray[np.float64]) -> None:
    """Refuses a mesh by the corners of its triangles, before anything is computed from them.

    Raises:
        ConfigError: Empty, not finite, of a size that is not allowed, or too far away.
    """
    problem = None
    if len(vertices_mm) == 0:
        problem = "is empty: it has no triangles"
    elif not np.isfinite(vertices_mm).all():
        problem = "has vertices that are not finite"
    else:
        extents = np.ptp(vertices_mm, axis=0)
        if not (extents.min() >= MIN_SIZE_MM and extents.max() <= MAX_SIZE_MM):
            size = " x ".join(f"{extent:.4g}" for extent in extents)
            problem = f"measures {size} mm: must be {MIN_SIZE_MM:g} to {MAX_SIZE_MM:g} mm; change scale"
        elif np.abs(vertices_mm).max() > MAX_PLACE_MM:
            far = np.abs(vertices_mm).max()
            problem = f"reaches {far:.4g} mm from its origin: at most {MAX_PLACE_MM:g} mm are allowed; move it there"
    if problem is not None:
        msg = f"mesh '{path}' {problem}"
        raise ConfigError(msg)


def _check(path: str, mesh: trimesh.Trimesh) -> None:
    """Refuses what cannot press.

    Raises:
        ConfigError: Too many triangles, or not watertight.
    """
    problem = None
    if len(mesh.faces) > MAX_TRIANGLES:
        problem = f"has {len(mesh.faces)} triangles: at most {MAX_TRIANGLES} are allowed"
    elif not (mesh.is_watertight and mesh.is_winding_consistent):
        problem = "is not watertight: every edge must belong to two triangles of consistent winding"
    if problem is not None:
        msg = f"mesh '{path}' {problem}"
        raise ConfigError(msg)


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(_load.cache_clear)
