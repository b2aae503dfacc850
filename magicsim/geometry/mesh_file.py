"""Reads the mesh of an object from a file, and refuses what cannot press."""

import atexit
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh

from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.mesh_shape import MeshShape

SUFFIXES = (".stl", ".obj", ".ply", ".glb")
MAX_TRIANGLES = 500_000
MIN_SIZE_MM, MAX_SIZE_MM = 0.01, 200.0
"""Least and largest extent of a mesh [mm]."""


def load_mesh(path: str, *, scale: float = 1.0, feature_mm: float | None = None) -> MeshShape:
    """Reads an STL, OBJ, PLY or GLB file; one unit of the file times `scale` is a millimetre.

    The last few files are kept, as long as they do not change.

    Raises:
        ConfigError: No such file, not readable as a mesh, empty, not watertight, too small, too large or too detailed.
    """
    file = Path(path)
    if file.suffix.lower() not in SUFFIXES:
        msg = f"mesh '{path}' is not allowed: must end in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise ConfigError(msg)
    try:
        stamp = file.stat().st_mtime_ns
        if not file.is_file():
            raise FileNotFoundError
    except OSError:
        msg = f"mesh '{path}' does not exist (paths are relative to the current directory)"
        raise ConfigError(msg) from None
    return _load(path, scale, feature_mm, stamp)


@lru_cache(maxsize=4)
def _load(path: str, scale: float, feature_mm: float | None, _stamp: int) -> MeshShape:
    try:
        mesh = trimesh.load_mesh(path)
        mesh = trimesh.Trimesh(np.asarray(mesh.vertices) * scale, mesh.faces, process=True)
    except Exception as error:  # the readers raise whatever they stumble on
        reason = str(error).partition("\n")[0] or type(error).__name__
        msg = f"mesh '{path}' cannot be read: {reason}"
        raise ConfigError(msg) from None
    _check(path, mesh)
    if mesh.volume < 0:
        mesh.invert()
    surface = SurfaceMesh(vertices=np.array(mesh.vertices, dtype=np.float64), faces=np.array(mesh.faces, np.int32))
    return MeshShape.of(surface, feature_mm=feature_mm)


def _check(path: str, mesh: trimesh.Trimesh) -> None:
    """Refuses what cannot press.

    Raises:
        ConfigError: Empty, too many triangles, not finite, not watertight, or of a size that is not allowed.
    """
    problem = None
    if len(mesh.faces) == 0:
        problem = "is empty: it has no triangles"
    elif len(mesh.faces) > MAX_TRIANGLES:
        problem = f"has {len(mesh.faces)} triangles: at most {MAX_TRIANGLES} are allowed"
    elif not np.isfinite(mesh.vertices).all():
        problem = "has vertices that are not finite"
    elif not (mesh.is_watertight and mesh.is_winding_consistent):
        problem = "is not watertight: every edge must belong to two triangles of consistent winding"
    elif not (mesh.extents.min() >= MIN_SIZE_MM and mesh.extents.max() <= MAX_SIZE_MM):
        size = " x ".join(f"{extent:.4g}" for extent in mesh.extents)
        problem = f"measures {size} mm: must be {MIN_SIZE_MM:g} to {MAX_SIZE_MM:g} mm; change scale"
    if problem is not None:
        msg = f"mesh '{path}' {problem}"
        raise ConfigError(msg)


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(_load.cache_clear)
