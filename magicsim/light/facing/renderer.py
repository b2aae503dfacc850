"""Radiance of a sensor that another finger looks at: as without it, with finger and object as one thing outside."""

from dataclasses import replace
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.facing.body import FingerBody, all_placed, with_object
from magicsim.light.facing.glow import Glow
from magicsim.light.facing.shine import facing_light
from magicsim.light.frame.frame_light import LIFTED_DIGITS, lifted
from magicsim.light.renderer import Renderer
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.outside import Outside
from magicsim.scenes.view import View


class FacingRenderer(Renderer):
    """Renders views that have a facing finger; shares the untouched states of the renderer that it stands beside.

    The finger is one of this sensor's own kind or another, at full light. Its face glows alike in all directions, as
    bright as it is there; light on its way into this block has the directions that it left with.
    """

    glow: Glow
    body: FingerBody

    @classmethod
    def beside(cls, plain: Renderer, companion: SurfaceMesh | None = None, *, other: Renderer | None = None) -> Self:
        """For the sensor of a renderer, with the same object.

        Args:
            plain: Renders the sensor without another finger.
            companion: What may be seen beside the object and touches nothing, with colours, in its own frame.
            other: Renders the finger that faces the sensor; by default one as the sensor.
        """
        facing = other or plain
        design, rig = facing.elastomer.design, facing.rig
        depth = design.height_mm + rig.lens.thickness_mm + rig.camera.distance_mm
        body = FingerBody.of(design.footprint_mm, depth)
        glow = Glow.of(facing.light(View()), facing.careful().light, design, body)
        mesh, finish = with_object(body, plain.object_mesh, plain.object_finish, glow.reflectance, companion)
        found = cls(
            plain.elastomer, plain.rig, plain.settings, seed=plain.seed, object_mesh=mesh, object_finish=finish,
            untouched=plain.untouched_states,
        )  # fmt: skip
        found.body, found.glow = body, glow
        found._object_vertices, found._companion_vertices = (
            each.vertices if each is not None else np.zeros((0, 3)) for each in (plain.object_mesh, companion)
        )
        last = mesh.faces.shape[0] - body.mesh.faces.shape[0]
        found._beside = (last - (len(companion.faces) if companion is not None else 0), last)
        found._own = found._own_irradiance(mesh.faces.shape[0], finish.specular)
        return found

    _object_vertices: Array
    _companion_vertices: Array
    _beside: tuple[int, int]
    _own: Array

    def _own_irradiance(self, triangles: int, specular: float) -> Array:
        """Irradiance that makes each triangle as bright as its own light does, shape (triangles, 3)."""
        exitance = self.body.triangles(self.glow.exitance[::-1])  # turned about y
        own = np.zeros((triangles, 3))
        own[triangles - len(exitance) :] = exitance / (self.glow.reflectance * (1 - specular))
        return own

    def _placed(self, view: View) -> Array | None:
        if view.facing_mm is None:
            return None
        poses = (view.indenter.pose if view.indenter is not None else None, view.companion)
        rigid = (self._object_vertices, self._companion_vertices)
        things = [
            (None if pose is None else pose.to_sensor(own), len(own)) for pose, own in zip(poses, rigid, strict=True)
        ]
        return all_placed(self.body, view.facing_mm, *things)

    def light(self, view: View) -> LitWorld:
        """As of every renderer; few rays go out from what stands beside the object."""
        world = super().light(view)
        world.beside = self._beside
        return world

    def _touching(self, placed: Array) -> Array:
        return placed[: len(self._object_vertices)]

    def _lifted(self, view: View, placed: Array) -> Array:
        """The object lifted, all else at whole millimetres: what is common to both states cancels, whatever it is."""
        thing, companion = lifted(self._touching(placed)), None
        if view.companion is not None:
            near = replace(view.companion, position_mm=np.round(view.companion.position_mm))
            companion = np.round(near.to_sensor(self._companion_vertices), LIFTED_DIGITS)
        things = ((thing, len(thing)), (companion, len(self._companion_vertices)))
        return all_placed(self.body, max(1.0, round(view.facing_mm or 0.0)), *things)

    def _within_reach(self, view: View) -> View:
        return view

    def _arrived(self, view: View, world: LitWorld, outside: Outside | None, field: LightField) -> LightField:
        if view.facing_mm is None:
            return field
        added = facing_light(
            world, outside, self.glow, view.facing_mm, self.elastomer.design.footprint_mm, seed=self.seed,
            most=self.settings.particles,
        )  # fmt: skip
        lit = total([field, added])
        return replace(lit, irradiance=lit.irradiance + self._own)

    def _gathered(self, view: View, before: LightField, lit: LightField) -> LightField:
        if view.facing_mm is None:
            return lit
        is_kept = (lit.irradiance == before.irradiance).all(1, keepdims=True)  # no ray gathered anything there
        return replace(lit, irradiance=np.where(is_kept, lit.irradiance, lit.irradiance + self._own))
