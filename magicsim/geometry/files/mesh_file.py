"""Reads the mesh of an object from a file, and refuses what cannot press."""

import atexit
import io
import logging
import os
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import igl
import numpy as np
import trimesh
from trimesh.resolvers import FilePathResolver

from magicsim.arrays import Array
from magicsim.config.documents import parse_json
from magicsim.config.named_files import MESH_SUFFIXES
from magicsim.config.presets import PATHS_START, is_file
from magicsim.errors import ConfigError
from magicsim.folder.listing import sha256_of
from magicsim.geometry.files.polygons import off_as_obj, triangulated_obj, triangulated_ply
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.shapes.mesh_solid import MeshShape

LOGGER = logging.getLogger(__name__)
logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # its errors are reported once, by us
MAX_BYTES = 200_000_000
"""Largest file: text with as many triangles as are allowed has about 130 MB."""
MAX_TRIANGLES = 500_000
MAX_PAIRS, SAMPLED_EDGES = 3e8, 64
"""Most pairs of an edge and a triangle whose boxes meet, and edges of which they are estimated: needles that share a
corner have as many as their number squared, and every distance takes as long as all of them."""
MAX_VALUES = 3 * MAX_TRIANGLES
"""Most values of one kind in a GLB file."""
MAX_JSON = 16_000_000
"""Longest JSON of a GLB file [bytes]."""
MIN_SIZE_MM, MAX_SIZE_MM = 0.01, 200.0
"""Least and largest extent of a mesh [mm]."""
MAX_PLACE_MM = 10_000.0
"""Farthest from its origin that a mesh may lie [mm]: files hold single precision."""
MM_PER_UNIT = {".glb": 1000.0}
"""Unit of each format whose standard names one [mm]."""
SMALL_MM = 5.0
"""Across which a mesh whose scale nobody gave may be in metres or inches [mm]."""
UNITS = {b"inch": 25.4, b"inches": 25.4, b"metre": 1000, b"metres": 1000, b"meter": 1000, b"meters": 1000, b"cm": 10,
         b"centimeters": 10, b"centimetres": 10, b"m": 1000, b"in": 25.4}  # fmt: skip
UNIT = re.compile(
    rb"units?[ \t]*[:=]?[ \t]*(?:(?:is|are|in)[ \t]+)*(?!in[ \t]+\w)(" + b"|".join(UNITS) + rb")\b", re.IGNORECASE
)
"""How headers and comments name one."""
UNIT_BYTES = 4096
"""Length of the beginning that is searched for it."""
JITTER = 1e-9
"""Random motion of the vertices, in units of the mesh's size: faces that lie in one plane then cross, or do not."""


def load_mesh(path: str, *, scale: float | None = None, feature_mm: float | None = None) -> MeshShape:
    """Reads an STL, OBJ, PLY, OFF or GLB file; z is up, and one unit of the file has `scale` millimetres.

    Without a scale it is one millimetre, and of GLB files, whose standard says metres and y up (glTF 2.0, 3.4), 1000; a
    size or a header that tells of another unit is warned about.

    The last few meshes are kept, known by the whole path and the content of their file. A surface that passes through
    itself is warned about: contact is that of its outside, which is the same as if its parts were one.

    Raises:
        ConfigError: No such file, not readable as a mesh, empty, not watertight, too small, too large or too detailed.
    """
    file = Path(path)
    if file.suffix.lower() not in MESH_SUFFIXES:
        *others, last = MESH_SUFFIXES
        raise ConfigError(f"mesh '{path}' is not allowed: must end in {', '.join(others)} or {last}")
    if not is_file(file):
        raise ConfigError(f"mesh '{path}' does not exist ({PATHS_START})")
    if (size := file.stat().st_size) > MAX_BYTES:  # before its content is hashed
        raise ConfigError(f"mesh '{path}' has {size / 1e6:.0f} MB: at most {MAX_BYTES / 1e6:.0f} MB are allowed")
    return _load(path, scale, feature_mm, os.path.abspath(path), sha256_of(file))


def mm_per_unit(path: str, scale: float | None) -> float:
    """Millimetres per unit of a mesh file: the scale that is given, or the one of its format."""
    return scale if scale is not None else MM_PER_UNIT.get(Path(path).suffix.lower(), 1.0)


def read_mesh(path: str, *, with_colors: bool = True) -> trimesh.Trimesh:
    """Vertices, triangles and, where asked for, colours of a file in its own units, z up, nothing merged or mended."""
    suffix = Path(path).suffix.lower()
    options: dict[str, Any] = {"process": False} | ({"skip_materials": not with_colors} if suffix == ".obj" else {})
    kind = ".obj" if suffix == ".off" else suffix
    if (content := _triangulated(path, suffix)) is not None:
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type=kind[1:], resolver=FilePathResolver(path), **options)
    else:
        mesh = trimesh.load_mesh(path, **options)
    if suffix == ".glb":
        mesh.vertices = np.asarray(mesh.vertices)[:, [0, 2, 1]] * (1, -1, 1)
    return mesh


def _triangulated(path: str, suffix: str) -> bytes | None:
    """The content of a file of polygons as its reader wants it; None where that takes the file as it is."""
    if suffix == ".off":
        text = off_as_obj(Path(path).read_bytes())
        return triangulated_obj(text) or text
    change = {".obj": triangulated_obj, ".ply": triangulated_ply}.get(suffix)
    return change(Path(path).read_bytes()) if change is not None else None


@lru_cache(maxsize=4)
def _load(path: str, scale: float | None, feature_mm: float | None, _whole_path: str, _digest: str) -> MeshShape:
    surface = _closed_surface(path, mm_per_unit(path, scale))
    if scale is None and (hint := _unit_hint(Path(path), float(np.ptp(surface.vertices, axis=0).max()))):
        LOGGER.warning("mesh '%s' %s", path, hint)
    if crossing := crossing_edges(surface):
        LOGGER.warning(
            "mesh '%s' passes through itself: %d of its edges cross other triangles; contact is that of its outside",
            path, crossing,
        )  # fmt: skip
    return MeshShape.of(surface, feature_mm=feature_mm)


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(_load.cache_clear)


def _unit_hint(path: Path, across_mm: float) -> str | None:
    """What tells that the unit of a file is not the one that is taken; None where nothing does."""
    with path.open("rb") as file:
        named = UNIT.search(file.read(UNIT_BYTES))
    if named is not None and path.suffix.lower() not in MM_PER_UNIT:
        factor = UNITS[named[1].lower()]
        return f"says that its unit is '{named[1].decode()}': scale={factor:g} would take it as that"
    if across_mm < SMALL_MM:
        return f"is {across_mm:.4g} mm across: if its unit is the metre, scale=1000; if it is the inch, scale=25.4"
    return None


def _closed_surface(path: str, scale: float) -> SurfaceMesh:
    try:
        problem = _announced_problem(Path(path))
        if problem is None:
            loaded = read_mesh(path, with_colors=False)
            used = np.unique(loaded.faces)
            if used.min(initial=0) < 0:  # the readers count it from the end
                problem = "has a face that names a vertex that is not there"
            else:
                problem = _size_problem(np.asarray(loaded.vertices, np.float64)[used] * scale, scale)
        if problem is None:
            mesh = trimesh.Trimesh(loaded.vertices, loaded.faces, process=True)
            mesh = trimesh.Trimesh(np.asarray(mesh.vertices) * scale, mesh.faces, process=True)
            mesh.update_faces((mesh.faces != np.roll(mesh.faces, 1, axis=1)).all(axis=1))  # no triangle of two corners
            problem = _solid_problem(mesh)
        if problem is None:
            if mesh.volume < 0:
                mesh.invert()
            surface = SurfaceMesh(vertices=np.array(mesh.vertices, np.float64), faces=np.array(mesh.faces, np.int32))
            inverted = inside_out_parts(surface)
            if not inverted:
                return surface
            problem = f"has parts that are inside out ({inverted} of them): turn their normals outwards"
    except Exception as error:  # the readers raise whatever they stumble on
        problem = f"cannot be read: {str(error).splitlines()[0] if str(error) else type(error).__name__}"
    raise ConfigError(f"mesh '{path}' {problem}")


def _announced_problem(path: Path) -> str | None:
    """Why a file is not given to its reader, by what it announces; None where nothing is against it.

    The readers keep a broken file within a few times its own size. But a GLB file is believed, so that its lengths,
    counts and repetitions are read here; and a broken STL is empty to its reader, which does not say what is wrong.

    Raises:
        ValueError: The file is broken.
    """
    count = {".stl": _stl_triangles, ".obj": _obj_triangles, ".ply": _ply_triangles, ".off": _off_triangles,
             ".glb": _glb_triangles}  # fmt: skip
    triangles = count[path.suffix.lower()](path.read_bytes()) if path.stat().st_size else 0
    if triangles == 0:
        return "is empty: it has no triangles"
    return _too_many(triangles)


def _too_many(triangles: int) -> str | None:
    return f"has {triangles} triangles: at most {MAX_TRIANGLES} are allowed" if triangles > MAX_TRIANGLES else None


def _stl_triangles(content: bytes) -> int:
    """80 bytes, the number of triangles, 50 bytes each; or text (Marshall Burns, Automated Fabrication, 1993)."""
    count, start = int.from_bytes(content[80:84], "little"), content[:1024]
    promised = 84 + 50 * count
    if len(content) == promised:
        return count
    start = start.lower().removeprefix(b"\xef\xbb\xbf").lstrip()
    if start[:5] == b"solid" and (b"facet" in start or b"endsolid" in start):
        _refuse_null(start)
        return content.lower().count(b"endfacet")
    raise ValueError(
        f"it is no text STL, and a binary one of the {count} triangles in its header has {promised} bytes; this one "
        f"has {len(content)}"
    )


def _obj_triangles(content: bytes) -> int:
    _refuse_null(content)
    return sum(1 for _ in re.finditer(rb"(?m)^[ \t]*f\s", content))


def _off_triangles(content: bytes) -> int:
    _refuse_null(content)
    return off_as_obj(content).count(b"\nf ")


def _refuse_null(text: bytes) -> None:
    if b"\0" in text:
        raise ValueError("it holds bytes that are no text")


def _ply_triangles(content: bytes) -> int:
    """A text header with the numbers of vertices and faces (Greg Turk, 1994); both take a byte at least."""
    counts = dict(re.findall(rb"element\s+(vertex|face)\s+(\d{1,18})\s", content[: 1 << 16]))
    vertices, faces = (int(counts.get(kind, 0)) for kind in (b"vertex", b"face"))
    if content[:3] != b"ply" or b"end_header" not in content:
        raise ValueError("it does not begin with a PLY header")
    if vertices + faces > len(content):
        msg = f"its header promises {vertices} vertices and {faces} faces, more than its {len(content)} bytes can hold"
        raise ValueError(msg)
    return faces


def _glb_triangles(content: bytes) -> int:
    """Chunks of given length, the first one JSON (glTF 2.0, section 4.4); a mesh counts as often as nodes show it."""
    length, chunk = (int.from_bytes(content[begin : begin + 4], "little") for begin in (8, 12))
    if content[:4] != b"glTF" or content[16:20] != b"JSON" or chunk > MAX_JSON:
        raise ValueError("it does not begin with a GLB header and a JSON chunk of up to 16 MB")
    if length != len(content) or 20 + chunk > length:
        raise ValueError(f"its header promises {max(length, 20 + chunk)} bytes, and it has {len(content)}")
    tree = parse_json(content[20 : 20 + chunk].decode(), source="its JSON")
    try:
        parts = [part for mesh in tree.get("meshes", ()) for part in mesh["primitives"]]
        positions = [part["attributes"]["POSITION"] for part in parts if "POSITION" in part.get("attributes", ())]
        is_coded = any(tree["accessors"][each].get("normalized") for each in positions)
        most = max((int(each["count"]) for each in tree.get("accessors", ())), default=0)
        triangles = sum(_shown_triangles(tree))
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError):
        raise ValueError("its JSON is no glTF") from None
    if is_coded or any("sparse" in each for each in tree.get("accessors", ())):
        raise ValueError("its positions are sparse, or shares of the largest integer: write them as plain numbers")
    if most > MAX_VALUES:
        raise ValueError(f"it has {most} values of one kind: at most {MAX_VALUES} are allowed")
    return triangles


def _shown_triangles(tree: dict[str, Any]) -> Iterator[int]:
    for number in (each["mesh"] for each in tree.get("nodes", ()) if "mesh" in each):
        for part in tree["meshes"][number]["primitives"]:
            corners = part["indices"] if "indices" in part else part["attributes"]["POSITION"]
            yield int(tree["accessors"][corners]["count"]) // 3


def _size_problem(corners_mm: Array, scale: float) -> str | None:
    """Why a mesh cannot press by the corners of its triangles, before anything is computed from them."""
    if len(corners_mm) == 0:
        return "is empty: it has no triangles"
    if not np.isfinite(corners_mm).all():
        return "has vertices that are not finite"
    extents, far = np.ptp(corners_mm, axis=0), np.abs(corners_mm).max()
    if not (extents.min() >= MIN_SIZE_MM and extents.max() <= MAX_SIZE_MM):
        size = " x ".join(f"{extent:.4g}" for extent in extents)
        wanted = "metres? try scale=1000" if extents.max() < MIN_SIZE_MM else "change scale"
        if scale == MM_PER_UNIT[".glb"] and extents.max() <= scale * MAX_SIZE_MM:
            wanted = "millimetres? try scale=1"
        return f"measures {size} mm: must be {MIN_SIZE_MM:g} to {MAX_SIZE_MM:g} mm; {wanted}"
    if far > MAX_PLACE_MM:
        return f"reaches {far:.4g} mm from its origin: at most {MAX_PLACE_MM:g} mm are allowed; move it there"
    return None


def _solid_problem(mesh: trimesh.Trimesh) -> str | None:
    if too_many := _too_many(len(mesh.faces)):  # a polygon of an OBJ or PLY file is several
        return too_many
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        return "is not watertight: every edge must belong to two triangles of consistent winding"
    return _needle_problem(np.asarray(mesh.vertices)[mesh.faces])


def _needle_problem(corners: Array) -> str | None:
    """Why triangles, shape (triangles, 3, 3), are too long and thin to be searched in a time that is worth it."""
    if (edges := 1.5 * len(corners)) * len(corners) < MAX_PAIRS:
        return None
    low, high = corners.min(1), corners.max(1)
    random, near = np.random.default_rng(0), 0
    triangle, first = random.integers(0, len(corners), SAMPLED_EDGES), random.integers(0, 3, SAMPLED_EDGES)
    for ends in np.stack([corners[triangle, first], corners[triangle, (first + 1) % 3]], axis=1):
        meets = np.flatnonzero((low[:, 0] <= ends[:, 0].max()) & (high[:, 0] >= ends[:, 0].min()))
        near += int(((low[meets] <= ends.max(0)) & (high[meets] >= ends.min(0))).all(1).sum())
    if near / SAMPLED_EDGES * edges < MAX_PAIRS:
        return None
    return (
        f"has {len(corners)} triangles that are long and thin, each among {near // SAMPLED_EDGES} others: mesh it anew"
    )


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
        (edge, hit[0]) for edge, each in enumerate(tree.intersect_ray(moved, faces, begin, along)) for hit in each
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
    part_of = np.asarray(trimesh.graph.connected_component_labels(ends, count))  # type: ignore[no-untyped-call]
    parts = int(part_of.max()) + 1
    a, b, c = (surface.vertices[faces[:, corner]] for corner in range(3))
    volumes = np.zeros(parts)
    np.add.at(volumes, part_of[faces[:, 0]], np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)
    low, high = np.full((parts, 3), np.inf), np.full((parts, 3), -np.inf)
    np.minimum.at(low, part_of, surface.vertices)
    np.maximum.at(high, part_of, surface.vertices)
    solid, inverted = np.flatnonzero(volumes > 0), np.flatnonzero(volumes < 0)
    return sum(not ((low[solid] < low[each]) & (high[each] < high[solid])).all(axis=1).any() for each in inverted)
