"""Reads the mesh of an object from a file, and refuses what cannot press."""

import atexit
import logging
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import trimesh

from magicsim.config.presets import PATHS_START, is_file
from magicsim.errors import ConfigError
from magicsim.geometry.files.mesh_crossing import crossing_edges, inside_out_parts
from magicsim.geometry.files.mesh_header import MAX_TRIANGLES, header_problem
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.shapes.mesh_solid import MeshShape

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
