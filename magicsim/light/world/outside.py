"""What stands before the undeformed block, in a scene of its own: the search tree of the grid is then built once.

The block never shares a place with it, so a ray that runs outside meets whichever is nearer. A kernel on an NVIDIA GPU
holds one scene only: there, passes through the block follow their rays in a third scene, of block and object.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.variant import CUDA_VARIANT
from magicsim.light.world.finish import Finish
from magicsim.light.world.names import FLASHLIGHT, OBJECT
from magicsim.light.world.next_hit import flat
from magicsim.light.world.scene_dict import WorldContent, flashlight_entry, flashlight_place, mesh_shape
from magicsim.light.world.shapes import shape_named
from magicsim.scenes.rig import Rig


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
        self.joined = load(content) if VARIANT == CUDA_VARIANT and object_mesh is not None else None
        """The block with all of this before it; None where passes trace two scenes, or there is no object."""
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
