"""Colours of a mesh file, read at any point of its surface."""

from typing import Any

import igl
import numpy as np
import trimesh

from magicsim.arrays import Array
from magicsim.conventions import MAX_PIXELS
from magicsim.errors import ConfigError
from magicsim.geometry.files.mesh_file import read_mesh
from magicsim.notebook.screen import from_srgb


def file_colors(path: str, points: Array) -> Array:
    """Diffuse reflectance at points of a mesh's surface, in linear RGB, from its texture, its vertices or its faces.

    Points are in the units of an OBJ, PLY or GLB file, z up, shape (points, 3); `ConfigError` where it has no colours.
    """
    mesh = read_mesh(path)
    visual: Any = mesh.visual
    picture = _image(visual) if visual.kind == "texture" and visual.uv is not None else None
    if picture is None and visual.kind not in {"vertex", "face"}:
        raise ConfigError(f"file_colors = true is not allowed: mesh '{path}' has neither a texture nor colours")
    if picture is not None and picture.width * picture.height > MAX_PIXELS:
        raise ConfigError(
            f"mesh '{path}' has a texture of {picture.width} x {picture.height} pixels: at most "
            f"{MAX_PIXELS / 1e6:.0f} million are allowed"
        )
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    tree = igl.AABB()
    tree.init(vertices, faces)
    _, face, foot = tree.squared_distance(vertices, faces, np.ascontiguousarray(points))
    corners = vertices[faces[face]]
    weights = trimesh.triangles.points_to_barycentric(corners, foot)  # type: ignore[no-untyped-call]
    if picture is not None:
        uv = np.einsum("pc,pci->pi", weights, np.asarray(visual.uv)[faces[face]])
        color = trimesh.visual.color.uv_to_interpolated_color(uv, picture)
    elif visual.kind == "vertex":
        color = np.einsum("pc,pci->pi", weights, np.asarray(visual.vertex_colors, np.float64)[faces[face]])
    else:
        color = np.asarray(visual.face_colors)[face]
    return from_srgb(np.asarray(color, np.float64)[:, :3] / 255)


def _image(visual: Any) -> Any:  # noqa: ANN401 -- of trimesh, without types
    material = visual.material
    return getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
