"""What stands before the undeformed block, in a scene of its own: the search tree of the grid is then built once.

The block never shares a place with it, so a ray that runs outside meets whichever is nearer.
"""

from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import dr, mi
from magicsim.light.world.finish import Finish
from magicsim.light.world.names import FLASHLIGHT, OBJECT
from magicsim.light.world.next_hit import flat
from magicsim.light.world.scene_dict import flashlight_entry, flashlight_place, mesh_shape
from magicsim.light.world.shapes import shape_named
from magicsim.scenes.rig import Rig


class Outside:
    """Object, flashlight or both, which can be moved."""

    def __init__(self, rig: Rig, *, object_mesh: SurfaceMesh | None, object_finish: Finish, flashlight: bool) -> None:
        """Loads them, the object parked where its own frame puts it.

        Args:
            rig: What surrounds the block.
            object_mesh: The object in its own frame, or None where there is none.
            object_finish: Its surface.
            flashlight: Whether it is on.
        """
        scene: dict[str, Any] = {"type": "scene"}
        if object_mesh is not None:
            scene[OBJECT] = mesh_shape(object_mesh, OBJECT, object_finish.bsdf())
        if flashlight:
            scene[FLASHLIGHT] = flashlight_entry(rig, 0.0)
        self.rig = rig
        self.scene: Any = mi.load_dict(scene, optimize=False)
        self.object: Any = shape_named(self.scene, OBJECT)
        """Its shape, or None."""
        self.flashlight: Any = shape_named(self.scene, FLASHLIGHT)
        """Its shape, or None."""
        self._parameters = mi.traverse(self.scene)

    def place(self, *, object_vertices: Array | None, light_x_mm: float | None) -> None:
        """Moves what is there.

        Args:
            object_vertices: Shape (object vertices, 3), in the sensor's frame [mm].
            light_x_mm: Shift of the flashlight along x [mm].
        """
        if object_vertices is not None:
            self._parameters[f"{OBJECT}.vertex_positions"] = np.ascontiguousarray(object_vertices, np.float32).ravel()
        if light_x_mm is not None:
            self._parameters[f"{FLASHLIGHT}.to_world"] = mi.Transform4f(flashlight_place(self.rig, light_x_mm))
        self._parameters.update()


class Outsides:
    """One scene for each kind of content, loaded when it is first needed."""

    def __init__(self, rig: Rig, object_mesh: SurfaceMesh | None, object_finish: Finish) -> None:
        """Loads nothing yet.

        Args:
            rig: What surrounds the block.
            object_mesh: The object in its own frame, if one will come.
            object_finish: Its surface.
        """
        self._rig, self._mesh, self._finish = rig, object_mesh, object_finish
        self._kept: dict[tuple[bool, bool], Outside] = {}

    def of(self, object_vertices: Array | None, light_x_mm: float | None) -> Outside:
        """What stands outside, in its place.

        Args:
            object_vertices: Shape (object vertices, 3), in the sensor's frame [mm]; None where there is no object.
            light_x_mm: Shift of the flashlight along x [mm]; None while it is off.
        """
        key = (object_vertices is not None, light_x_mm is not None)
        if key not in self._kept:
            mesh = self._mesh if key[0] else None
            self._kept[key] = Outside(self._rig, object_mesh=mesh, object_finish=self._finish, flashlight=key[1])
        self._kept[key].place(object_vertices=object_vertices, light_x_mm=light_x_mm)
        return self._kept[key]


def nearer_hit(outside: Any, ray: Any, si: Any, active: Any) -> Any:
    """The hit on what stands outside where it comes before another one.

    Args:
        outside: The scene of an `Outside`.
        ray: Rays.
        si: What they meet otherwise.
        active: Which of them run outside the block.
    """
    other = flat(outside.ray_intersect(ray, active), ray)
    return dr.select(active & other.is_valid() & (other.t < si.t), other, si)
