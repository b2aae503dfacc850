"""The shapes of a loaded scene by their role."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import columns, dr, mi, pointer
from magicsim.light.cells.cell_faces import CellFaces
from magicsim.light.world.finish import COLORS
from magicsim.light.world.medium import Segment, classify
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT

CLEAR_MM = 1e-3
"""How far off its triangles an object is looked around from [mm]: less than a wet object stands into the skin."""


@dataclass(slots=True, kw_only=True)
class Shapes:
    """The shapes that both passes tell apart, by their role."""

    body: Any
    infill: Any
    """All cells, or None without a grid."""
    object: Any
    triangles_per_cell: int
    faces: CellFaces | None
    """Faces of the cells, for `next_hit`; None to search all triangles for every hit."""
    openings: Any = None
    """Cell behind each triangle that is a membrane in a missing wall, see `FusedCells.beyond`, mi.UInt32; None where
    no wall is missing."""
    outside: Any = None
    """A scene of its own that holds object, flashlight or both, or None where they are in the block's."""
    coating: Any = None
    """`Coating` of the contact face, or None where it is bare."""
    environment: Any = None
    """What shines from all around, or None."""
    room: Any = None
    """What alone shines, from all around, in place of the scene's lights; None where those do."""
    scatterers: Any = None
    """`Scatterers` in the cells, or None where the print is clean."""

    @property
    def cells(self) -> int:
        """Number of cells, at least 1 so that arrays have a size."""
        return max(1, self.infill.face_count() // self.triangles_per_cell) if self.infill is not None else 1

    @property
    def object_triangles(self) -> int:
        """Number of the object's triangles, at least 1 so that arrays have a size."""
        return int(self.object.face_count()) if self.object is not None else 1

    def cell(self, si: Any, segment: Segment) -> Any:
        """Number of the cell that rays ran through, of those that ran through one, mi.UInt32."""
        own = si.prim_index // self.triangles_per_cell
        return own if segment.beyond is None else dr.select(segment.entering & segment.opening, segment.beyond, own)

    def pointers(self) -> tuple[Any, Any, Any]:
        """Body, infill and object for comparison with hits; null, which no valid hit equals, where one is absent."""
        return pointer(self.body), pointer(self.infill), pointer(self.object)


def lights(scene: Any) -> list[str]:
    """Names of the lights, in a fixed order: LEDs, ring and strips by name, light from all around, flashlight.

    The flashlight is last: it may stand in a scene of its own, of which the other lights' random numbers must not tell.
    """
    names = {shape.id() for shape in scene.shapes() if shape.is_emitter()}
    around = [ENVIRONMENT] if scene.environment() is not None else []
    return sorted(names - {FLASHLIGHT}) + around + sorted(names & {FLASHLIGHT})


def shape_named(scene: Any, name: str) -> Any:
    """The shape of a scene with a name, or None."""
    return next((shape for shape in scene.shapes() if shape.id() == name), None)


def mesh_shape(
    mesh: SurfaceMesh, name: str, bsdf: dict[str, Any], *, texture: Array | None = None, **parts: Any
) -> Any:
    """A mesh as the renderer's shape.

    Args:
        mesh: Its triangles, and colours of vertices if it has any.
        name: Of the shape.
        bsdf: Entry of its material.
        texture: Places of vertices in pictures, shape (vertices, 2).
        parts: Media inside and outside (`interior`, `exterior`), None where they are clear, and `emitter`.
    """
    properties = mi.Properties()
    properties["bsdf"], properties["face_normals"] = mi.load_dict(bsdf), True
    for part, value in parts.items():
        if value is not None:
            properties[part] = value
    textured = texture is not None
    shape = mi.Mesh(name, len(mesh.vertices), len(mesh.faces), props=properties, has_vertex_texcoords=textured)
    parameters = mi.traverse(shape)
    if texture is not None:
        parameters["vertex_texcoords"] = np.ascontiguousarray(texture, np.float32).ravel()
    parameters["vertex_positions"] = np.ascontiguousarray(mesh.vertices, np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(mesh.faces, np.uint32).ravel()
    parameters.update()
    if mesh.colors is not None:
        shape.add_attribute(COLORS, 3, np.ascontiguousarray(mesh.colors, np.float32).ravel())
    shape.set_id(name)
    return shape


def matt(reflectance: Any) -> dict[str, Any]:
    """Entry of a diffuse material, grey or of one reflectance a channel."""
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}}


def shining(radiance: Sequence[float], kind: str = "area", **more: Any) -> dict[str, Any]:
    """Entry of a light of some kind on a surface."""
    return {"type": kind, "radiance": {"type": "rgb", "value": list(radiance)}, **more}


def mesh_of(shape: Any) -> SurfaceMesh:
    """Vertices and faces of a mesh as they are now."""
    parameters = mi.traverse(shape)
    return SurfaceMesh(
        vertices=np.array(parameters["vertex_positions"], np.float64).reshape(-1, 3),
        faces=np.array(parameters["faces"]).reshape(-1, 3).astype(np.int32),
    )


def wetted(scene: Any, shapes: Shapes) -> npt.NDArray[np.bool_]:
    """Which of the object's triangles lie inside the body's surface, shape (triangles,)."""
    if shapes.object is None or shapes.outside is not None:
        return np.zeros(shapes.object_triangles, bool)
    mesh = mesh_of(shapes.object)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return np.array(in_body(scene, shapes, mi.Point3f(*columns(corners.mean(1) + CLEAR_MM * normals))))


def in_body(scene: Any, shapes: Shapes, points: Any) -> Any:
    """Which points outside object and cells lie inside the body's surface, on the object's side of the skin."""
    body, infill, _ = shapes.pointers()
    si = scene.ray_intersect(mi.Ray3f(points, mi.Vector3f(0, 0, 1)))
    return classify(si, body, infill, mi.Bool(False), shapes.openings).in_body
