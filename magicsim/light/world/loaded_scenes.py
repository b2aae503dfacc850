"""The Mitsuba scenes of one sensor, one for each kind of content, brought into the state of a view."""

from collections.abc import Callable
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import World
from magicsim.light.world.marker_disks import marker_disks
from magicsim.light.world.scene_dict import WorldContent
from magicsim.scenes.view import View

NOWHERE = np.zeros((0, 3))


class Worlds:
    """Scenes with and without object and flashlight; only what differs from the last view is moved."""

    def __init__(
        self,
        elastomer: Elastomer,
        object_mesh: SurfaceMesh | None,
        object_finish: Finish,
        load: Callable[[WorldContent], World],
    ) -> None:
        """Loads nothing yet.

        Args:
            elastomer: The block.
            object_mesh: The object in its own frame, if one will come.
            object_finish: Its surface.
            load: Loads the scene of some content.
        """
        self._elastomer, self._load = elastomer, load
        self._mesh, self._finish = object_mesh, object_finish
        self._kept: dict[tuple[bool, bool], World] = {}
        self._shown: dict[tuple[bool, bool], View] = {}
        self._placed: dict[tuple[bool, bool], Array] = {}

    def of(self, view: View, object_vertices: Array | None) -> World:
        """The scene that shows a view, loaded when it is first needed.

        Args:
            view: What to see.
            object_vertices: Of the object where it is, shape (vertices, 3) [mm]; None where there is none.
        """
        key = (object_vertices is not None, view.flashlight_x_mm is not None)
        if key not in self._kept:
            content = WorldContent(
                object_mesh=self._mesh if key[0] else None, object_finish=self._finish, flashlight=key[1]
            )
            self._kept[key] = self._load(content)
        changes = self._changes(self._shown.get(key, View()), view)
        if object_vertices is not None and not np.array_equal(self._placed.get(key, NOWHERE), object_vertices):
            changes["object_vertices"] = self._placed[key] = object_vertices
        if changes:
            self._kept[key].update(**changes)
        self._shown[key] = view
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
