"""The persistent Mitsuba scenes of one sensor: built once, afterwards only their vertices move.

What stands before the undeformed block has a scene of its own, so that the search tree of the grid is built once. The
block never shares a place with it, so a ray that runs outside meets whichever is nearer. A kernel on an NVIDIA GPU
holds one scene only: there, passes through the block follow their rays in a third scene, of block and object.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.flaws.scatterers import scatterer_name, transforms
from magicsim.light.variant import CUDA_VARIANT
from magicsim.light.world.finish import Finish
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.light.world.names import BODY, ENVIRONMENT, FACE, FLASHLIGHT, GROUPED, INFILL, MARKERS, OBJECT
from magicsim.light.world.next_hit import flat
from magicsim.light.world.scene_dict import (
    WorldContent,
    block_shapes,
    flashlight_entry,
    flashlight_place,
    in_group,
    scene_dict,
    with_lens,
)
from magicsim.light.world.shapes import lights, mesh_shape, shape_named
from magicsim.scenes.rig import Rig
from magicsim.scenes.timeline import View

NOWHERE = np.zeros((0, 3))
UNKNOWN = View(body=NOWHERE, infill=NOWHERE, markers=NOWHERE, flashlight_x_mm=math.nan)
"""What a scene shows whose update was interrupted: anything differs from it."""
RADIANCE = ".radiance.value"
"""What the renderer calls the radiance of a light, after its name."""


class World:
    """One Mitsuba scene whose vertices can be replaced."""

    def __init__(self, elastomer: Elastomer, rig: Rig, content: WorldContent, *, for_paths: bool = True) -> None:
        """Loads the scene at rest, the object parked where its own frame puts it.

        For Mitsuba's own integrators the block is no group of shapes, see `block_shapes`.
        """
        self.elastomer = elastomer
        self.rig = rig
        self.content = content
        self._has_face = for_paths and elastomer.design.face_is_special
        self.block = block_shapes(elastomer, rig, for_paths=for_paths)
        """Shapes of the block by their names."""
        self._prefix = "" if for_paths else GROUPED
        entries = self.block if for_paths else in_group(self.block)
        self.scene: Any = mi.load_dict(
            scene_dict(elastomer, rig, content, entries, for_paths=for_paths), optimize=False
        )
        self._parameters = mi.traverse(self.scene)
        self._radiance = {
            key: type(self._parameters[key])(self._parameters[key])
            for key in self._parameters.keys()  # noqa: SIM118 -- not a dict
            if key.endswith(RADIANCE) or key == f"{ENVIRONMENT}.scale"
        }

    @property
    def lights(self) -> list[str]:
        """Names of all lights of the scene."""
        return lights(self.scene)

    def update(
        self,
        *,
        body: Array | None = None,
        infill: Array | None = None,
        markers: Array | None = None,
        object_vertices: Array | None = None,
        light_x_mm: float | None = None,
    ) -> None:
        """Replaces vertices, shape (vertices, 3) in the sensor's frame [mm]; what is None stays as it is."""
        if body is not None:
            placed = with_lens(body, self.elastomer, self.rig)
            for name in (BODY, FACE) if self._has_face else (BODY,):
                self._set(self._prefix + name, placed)
        if markers is not None:
            self._set(MARKERS, markers)
        if infill is not None:
            self._set(self._prefix + INFILL, infill)
            if not self._prefix and self.elastomer.inclusions is not None:
                for number, place in enumerate(transforms(self.elastomer.inclusions.placed(infill))):
                    self._parameters[f"{scatterer_name(number)}.to_world"] = mi.Transform4f(place)
        if object_vertices is not None:
            self._set(self.content.object_name, object_vertices)
        if light_x_mm is not None:
            self._parameters[f"{FLASHLIGHT}.to_world"] = mi.Transform4f(flashlight_place(self.rig, light_x_mm))
        self._parameters.update()

    def light_only(self, name: str | None) -> None:
        """Turns all lights off but one; None turns all of them on again."""
        for key, radiance in self._radiance.items():
            self._parameters[key] = radiance if name in {key.partition(".")[0], None} else type(radiance)(0.0)
        self._parameters.update()

    def _set(self, name: str, vertices: Array) -> None:
        self._parameters[f"{name}.vertex_positions"] = np.ascontiguousarray(vertices, np.float32).ravel()


class Worlds:
    """Scenes with and without object and flashlight; only what differs from the last view is moved."""

    def __init__(
        self,
        elastomer: Elastomer,
        object_mesh: SurfaceMesh | None,
        object_finish: Finish,
        load: Callable[[WorldContent], World],
    ) -> None:
        self._elastomer, self._load = elastomer, load
        self._mesh, self._finish = object_mesh, object_finish
        self._kept: dict[tuple[bool, bool], World] = {}
        self._shown: dict[tuple[bool, bool], tuple[View, Array]] = {}
        """What each scene shows, and the object's vertices there."""

    def of(self, view: View, object_vertices: Array | None) -> World:
        """The scene that shows a view, loaded when first needed; vertices are those of the object where it is."""
        key = (object_vertices is not None, view.flashlight_x_mm is not None)
        if key not in self._kept:
            content = WorldContent(
                object_mesh=self._mesh if key[0] else None, object_finish=self._finish, flashlight=key[1]
            )
            self._kept[key] = self._load(content)
            self._shown[key] = View(), NOWHERE
        # What is shown is unknown until the update is whole, whatever interrupts it.
        shown, placed = self._shown.pop(key, (None, NOWHERE))
        changes = self._changes(shown or UNKNOWN, view)
        if object_vertices is not None and not np.array_equal(placed, object_vertices):
            changes["object_vertices"] = placed = object_vertices
        if changes:
            self._kept[key].update(**changes)
        self._shown[key] = view, placed
        return self._kept[key]

    def _changes(self, shown: View, view: View) -> dict[str, Any]:
        """Arguments of `World.update`."""
        changes: dict[str, Any] = {}
        if view.body is not shown.body:
            changes["body"] = view.body if view.body is not None else self._elastomer.body.vertices
        if view.infill is not shown.infill and self._elastomer.infill is not None:
            changes["infill"] = view.infill if view.infill is not None else self._elastomer.infill.vertices
        if view.markers is not shown.markers and (rest := marker_disks(self._elastomer.design)) is not None:
            changes["markers"] = view.markers if view.markers is not None else rest.vertices
        if view.flashlight_x_mm is not None and view.flashlight_x_mm != (shown.flashlight_x_mm or 0.0):
            changes["light_x_mm"] = view.flashlight_x_mm
        return changes


class Outside:
    """Object, flashlight or both, which can be moved."""

    def __init__(self, rig: Rig, content: WorldContent, load: Callable[[WorldContent], Any]) -> None:
        """Loads them, the object parked where its own frame puts it."""
        object_mesh, flashlight = content.object_mesh, content.flashlight
        scene: dict[str, Any] = {"type": "scene"}
        if object_mesh is not None:
            scene[OBJECT] = mesh_shape(object_mesh, OBJECT, content.object_finish.bsdf())
        if flashlight:
            scene[FLASHLIGHT] = flashlight_entry(rig)
        self.rig = rig
        self.scene: Any = mi.load_dict(scene, optimize=False)
        self.object: Any = shape_named(self.scene, OBJECT)
        """Shape of the object, or None."""
        self.flashlight: Any = shape_named(self.scene, FLASHLIGHT)
        """Shape of the flashlight, or None."""
        self.is_there = object_mesh is not None or flashlight
        """Whether anything stands outside."""
        self.joined = load(content) if VARIANT == CUDA_VARIANT and self.is_there else None
        """The block with all of this before it; None where passes trace two scenes, or nothing is there."""
        self._parameters = mi.traverse(self.scene)

    def place(self, *, object_vertices: Array | None, light_x_mm: float | None) -> None:
        """Moves object, vertices in the sensor's frame [mm], and flashlight along x [mm]."""
        if object_vertices is not None:
            self._parameters[f"{OBJECT}.vertex_positions"] = np.ascontiguousarray(object_vertices, np.float32).ravel()
        if light_x_mm is not None:
            self._parameters[f"{FLASHLIGHT}.to_world"] = mi.Transform4f(flashlight_place(self.rig, light_x_mm))
        self._parameters.update()
        if self.joined is not None:
            self.joined.update(object_vertices=object_vertices, light_x_mm=light_x_mm)


class Outsides:
    """One scene for each kind of content, loaded when it is first needed."""

    def __init__(
        self, rig: Rig, object_mesh: SurfaceMesh | None, object_finish: Finish, load: Callable[[WorldContent], Any]
    ) -> None:
        self._rig, self._mesh, self._finish, self._load = rig, object_mesh, object_finish, load
        self._kept: dict[tuple[bool, bool], Outside] = {}

    def of(self, object_vertices: Array | None, light_x_mm: float | None) -> Outside:
        """What stands outside, in its place; None where there is no object, or where the flashlight is off."""
        key = (object_vertices is not None, light_x_mm is not None)
        if key not in self._kept:
            mesh = self._mesh if key[0] else None
            content = WorldContent(object_mesh=mesh, object_finish=self._finish, flashlight=key[1])
            self._kept[key] = Outside(self._rig, content, self._load)
        self._kept[key].place(object_vertices=object_vertices, light_x_mm=light_x_mm)
        return self._kept[key]


def nearer_hit(outside: Any, ray: Any, si: Any, active: Any) -> Any:
    """The hit on what stands outside where it comes before another one."""
    other = flat(outside.ray_intersect(ray, active), ray)
    return dr.select(active & other.is_valid() & (other.t < si.t), other, si)
