"""The persistent Mitsuba scene of one sensor: built once, afterwards only its vertices move."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import mi
from magicsim.light.flaws.scatterers import scatterer_name, transforms
from magicsim.light.world.finish import Finish
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.light.world.names import BODY, ENVIRONMENT, FACE, FLASHLIGHT, GROUPED, INFILL, MARKERS
from magicsim.light.world.scene_dict import (
    WorldContent,
    block_shapes,
    flashlight_place,
    in_group,
    scene_dict,
    with_lens,
)
from magicsim.light.world.shapes import lights
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
