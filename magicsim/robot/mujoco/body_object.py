"""A body of a MuJoCo model as the object of a sensor."""

from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim.geometry.objects.rigid_object import REACH_FEATURES, REACH_MM, SHELL_MM, SHELL_SHARE, ObjectBase
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.entry import EntrySide
from magicsim.geometry.shapes.solids import Shape, Sphere
from magicsim.robot.mujoco.solids import MM, MjData, MjModel, body_solid

LINEAR_KNEE, LINEAR_SLOPE = 0.04045, 12.92
"""Where the curve of sRGB begins, and its slope below (IEC 61966-2-1)."""


class BodyObject(ObjectBase):
    """A solid in any orientation."""

    solid: Any
    """Shape of the body."""

    def shape(self) -> Shape:
        """The solid as it is, without a side of entry: that depends on its orientation."""
        solid: Shape = self.solid
        return solid

    def entered(self, pose: Pose) -> Shape:
        """The solid with contact by the side of entry along the sensor's z axis, in an orientation."""
        solid = self.shape()
        if isinstance(solid, Sphere):
            return solid
        x, y, z = pose.rotation[2].tolist()
        feature = solid.feature_mm
        shell, reach = min(SHELL_MM, SHELL_SHARE * feature), min(REACH_MM, REACH_FEATURES * feature)
        return EntrySide(solid, (x, y, z), shell, reach)


def body_object(model: MjModel, body: int) -> tuple[BodyObject, int | None]:
    """A body as an object, and the geom whose frame it is in; None stands for the body's frame.

    Geoms that take part in MuJoCo's contacts make the solid; where there are none, all of them do. The colour is that
    of the first one, read as sRGB.

    Args:
        model: `mujoco.MjModel`.
        body: Its number.

    Raises:
        ConfigError: The body has no geometry, or one that cannot press.
    """
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    if count == 0:
        raise ConfigError(f"body '{model.body(body).name}' has no geometry to touch a sensor with: give it a geom")
    geoms = list(range(first, first + count))
    colliding = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    solid, frame = body_solid(model, body, colliding or geoms)
    material = int(model.geom_matid[geoms[0]])
    rgba = model.geom_rgba[geoms[0]] if material < 0 else model.mat_rgba[material]
    specular = 0.0 if material < 0 else float(model.mat_reflectance[material])
    red, green, blue = _linear(np.asarray(rgba[:3], np.float64)).tolist()
    return BodyObject(solid=solid, color=(red, green, blue), specular=specular), frame


def object_pose_m(model: MjModel, data: MjData, body: int, frame: int | None) -> tuple[Array, Array]:
    """Where the object's frame is in the world: position, shape (3,) [m], and rotation, shape (3, 3)."""
    if frame is None:
        return np.array(data.xpos[body]), np.array(data.xmat[body]).reshape(3, 3)
    return np.array(data.geom_xpos[frame]), np.array(data.geom_xmat[frame]).reshape(3, 3)


def pose_in_sensor(position_m: Array, rotation: Array, site_position_m: Array, site_rotation: Array) -> Pose:
    """A frame of the world as a sensor at a site sees it.

    Args:
        position_m: Its origin, shape (3,) [m].
        rotation: Its rotation, shape (3, 3).
        site_position_m: The sensor's origin, shape (3,) [m].
        site_rotation: The sensor's rotation, shape (3, 3).
    """
    return Pose(
        position_mm=MM * (site_rotation.T @ (position_m - site_position_m)), rotation=site_rotation.T @ rotation
    )


def _linear(srgb: Array) -> Array:
    low = srgb / LINEAR_SLOPE
    high = ((srgb + 0.055) / 1.055) ** 2.4
    return np.asarray(np.clip(np.where(srgb <= LINEAR_KNEE, low, high), 0, 1))
