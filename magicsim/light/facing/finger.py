"""Another finger before the block: a box behind a contact face that glows, in one mesh with the object.

The renderer knows one thing that light falls on, so the finger, the object and what may accompany it share a mesh, each
triangle with its reflectance.
The finger is this sensor turned by half a turn about y, its face parallel to the face of this one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.facing.glow import Glow
from magicsim.light.frame.frame_light import LIFTED_DIGITS, lifted
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.world.finish import GREY, Finish
from magicsim.scenes.timeline import View

QUAD_MM = 2.0
"""Largest edge of the squares of the face, each of which has a brightness of its own [mm]."""
HOUSING = 0.05
"""Diffuse reflectance of the housing behind the face; assumed: black plastic."""
MOST_MIRRORED = 0.999
"""Largest share of light that is mirrored beside a finger, which has to glow through what it takes on of it."""
APART_MM = 1000.0
"""Where the finger is in the mesh that smoothing is made for, so that nothing spreads from it to the object [mm]; the
object's companion is twice as far."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerBody:
    """A box with its contact face at z = 0 and the rest below; vertices of face and housing are not shared."""

    mesh: SurfaceMesh
    counts: tuple[int, int]
    """Squares of the face along x and y."""
    face_vertices: int
    """How many vertices belong to the face; they come first."""

    @classmethod
    def of(cls, footprint_mm: tuple[float, float], depth_mm: float) -> Self:
        """A finger with a contact face of this size along x and y [mm], and so deep to the end of its housing [mm]."""
        counts = tuple(int(np.ceil(size / QUAD_MM)) for size in footprint_mm)
        half = np.array(footprint_mm) / 2
        axes = [np.linspace(-end, end, count + 1) for end, count in zip(half, counts, strict=True)]
        x, y = np.meshgrid(*axes, indexing="ij")
        face = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
        i, j = (each.ravel() for each in np.meshgrid(*(np.arange(count) for count in counts), indexing="ij"))
        a, b = i * (counts[1] + 1) + j, (i + 1) * (counts[1] + 1) + j
        # Two triangles a square, side by side, counter-clockwise seen from +z.
        squares = np.stack([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)], 1).reshape(-1, 3)
        corners = np.array(
            [[sx, sy, z] for z in (-depth_mm, 0.0) for sy in (-half[1], half[1]) for sx in (-half[0], half[0])]
        )
        # The box has no side at its face.
        sides = [(0, 2, 3, 1), *((a, b, b + 4, a + 4) for a, b in pairwise((0, 1, 3, 2, 0)))]
        box = [triangle for a, b, c, d in sides for triangle in ([a, b, c], [a, c, d])]
        mesh = SurfaceMesh(
            vertices=np.concatenate([face, corners]),
            faces=np.concatenate([squares, np.array(box) + len(face)]).astype(np.int32),
        )
        return cls(mesh=mesh, counts=(counts[0], counts[1]), face_vertices=len(face))

    def placed(self, distance_mm: float) -> Array:
        """Vertices with the face at a distance below the sensor's own, shape (vertices, 3) [mm]."""
        return np.asarray(self.mesh.vertices - np.array([0.0, 0.0, distance_mm]))

    def triangles(self, of_squares: Array) -> Array:
        """A value of each triangle from one of each square, 0 on the housing; shape (triangles, channels)."""
        flat = np.repeat(of_squares.reshape(-1, of_squares.shape[-1]), 2, axis=0)
        return np.concatenate([flat, np.zeros((len(self.mesh.faces) - len(flat), flat.shape[1]))])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FacingFinger:
    """A finger that looks back at a sensor, with what stands between them: one object to the renderer.

    Its face glows alike in all directions, as bright as it is there at full light; light on its way into this block has
    the directions that it left with. Views without a facing finger have nothing of it.
    """

    body: FingerBody
    glow: Glow
    mesh: SurfaceMesh
    """Object, companion and finger, in the frame that smoothing is made for."""
    finish: Finish
    object_vertices: Array
    """Vertices of the object in its own frame, shape (vertices, 3) [mm]; they come first in the mesh."""
    companion_vertices: Array
    """Vertices of the companion in its own frame, shape (vertices, 3) [mm]; they follow."""
    beside: tuple[int, int]
    """First triangle of the companion, and the first one after these: seen at the edge of the picture at most."""

    @classmethod
    def of(
        cls,
        body: FingerBody,
        glow: Glow,
        object_mesh: SurfaceMesh | None,
        finish: Finish,
        companion: SurfaceMesh | None,
    ) -> Self:
        """A finger with an object before it, and a companion that has colours and touches nothing."""
        mesh, joined = with_object(body, object_mesh, finish, glow.reflectance, companion)
        own, other = (each.vertices if each is not None else np.zeros((0, 3)) for each in (object_mesh, companion))
        last = len(mesh.faces) - len(body.mesh.faces)
        return cls(
            body=body, glow=glow, mesh=mesh, finish=joined, object_vertices=own, companion_vertices=other,
            beside=(last - (len(companion.faces) if companion is not None else 0), last),
        )  # fmt: skip

    def placed(self, view: View) -> Array | None:
        """Vertices of all in a view, in the sensor's frame, shape (vertices, 3) [mm]; None without a facing finger."""
        if view.facing_mm is None:
            return None
        poses = (view.indenter.pose if view.indenter is not None else None, view.companion)
        rigid = (self.object_vertices, self.companion_vertices)
        bodies = [
            (None if pose is None else pose.to_sensor(own), len(own)) for pose, own in zip(poses, rigid, strict=True)
        ]
        return all_placed(self.body, view.facing_mm, *bodies)

    def lifted(self, view: View, placed: Array) -> Array:
        """The object lifted, all else at whole millimetres: what is common to both states cancels, whatever it is."""
        lifted_object, companion = lifted(placed[: len(self.object_vertices)]), None
        if view.companion is not None:
            near = replace(view.companion, position_mm=np.round(view.companion.position_mm))
            companion = np.round(near.to_sensor(self.companion_vertices), LIFTED_DIGITS)
        bodies = ((lifted_object, len(lifted_object)), (companion, len(self.companion_vertices)))
        return all_placed(self.body, max(1.0, round(view.facing_mm or 0.0)), *bodies)

    def shining(self, field: LightField, added: LightField) -> LightField:
        """The light in the block with the finger's, and its own brightness on its face."""
        lit = total([field, added])
        return replace(lit, irradiance=lit.irradiance + self._own_irradiance)

    def gathered(self, before: LightField, lit: LightField) -> LightField:
        """The light with the finger's own brightness, where gathering light on the object has replaced it."""
        is_kept = (lit.irradiance == before.irradiance).all(1, keepdims=True)  # no ray gathered anything there
        return replace(lit, irradiance=np.where(is_kept, lit.irradiance, lit.irradiance + self._own_irradiance))

    @property
    def _own_irradiance(self) -> Array:
        """Irradiance that makes each triangle as bright as its own light does, shape (triangles, 3)."""
        exitance = self.body.triangles(self.glow.exitance[::-1])  # turned about y
        own = np.zeros((len(self.mesh.faces), 3))
        own[len(own) - len(exitance) :] = exitance / (self.glow.reflectance * (1 - self.finish.specular))
        return own


def with_object(
    body: FingerBody, object_mesh: SurfaceMesh | None, finish: Finish, reflectance: Array,
    companion: SurfaceMesh | None = None,
) -> tuple[SurfaceMesh, Finish]:  # fmt: skip
    """One mesh of object, companion and finger, in the frame that smoothing is made for, and its surface.

    All take on the object's share of mirrored light. The finger's face has `reflectance`, shape (3,); a companion
    without colours is grey.
    """
    colors = np.full((len(body.mesh.vertices), 3), HOUSING)
    colors[: body.face_vertices] = reflectance
    parts = [SurfaceMesh(vertices=body.placed(APART_MM), faces=body.mesh.faces, colors=colors)]
    if companion is not None:
        apart = companion.vertices - np.array([0.0, 0.0, 2 * APART_MM])
        parts.insert(0, _colored(replace(companion, vertices=apart), GREY))
    if object_mesh is None:
        return _joined(parts), Finish(vertex_colors=True)
    mesh = _joined([_colored(object_mesh, finish.color), *parts])
    return mesh, Finish(
        vertex_colors=True, specular=min(finish.specular, MOST_MIRRORED), roughness=finish.roughness
    )  # fmt: skip


def _colored(mesh: SurfaceMesh, color: tuple[float, float, float]) -> SurfaceMesh:
    """The mesh with its own colours, or with one for all of it."""
    return mesh if mesh.colors is not None else replace(mesh, colors=np.tile(color, (len(mesh.vertices), 1)))


def _joined(parts: Sequence[SurfaceMesh]) -> SurfaceMesh:
    """Meshes with colours as one, in their order."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return SurfaceMesh(
        vertices=np.concatenate([part.vertices for part in parts]),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]).astype(np.int32),
        colors=np.concatenate([part.colors for part in parts if part.colors is not None]),
    )


def all_placed(body: FingerBody, distance_mm: float, *bodies: tuple[Array | None, int]) -> Array:
    """Vertices of object, companion and finger where they are, shape (vertices, 3) [mm].

    `bodies` are vertices of what is before the finger, and how many it has; None where it is away: it then has no
    surface, at a point inside the finger.
    """
    finger = body.placed(distance_mm)
    inside = np.array([0.0, 0.0, (finger[:, 2].min() - distance_mm) / 2])
    shown = [np.tile(inside, (count, 1)) if vertices is None else vertices for vertices, count in bodies]
    return np.concatenate([*shown, finger])
