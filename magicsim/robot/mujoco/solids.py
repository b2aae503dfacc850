"""A body of a MuJoCo model as the object of a sensor: its solid, from its geoms, its colour and its pose.

MuJoCo has metres, a geom's own frame, and half sizes; shapes here have millimetres.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import manifold3d
import numpy as np
import trimesh

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.rigid_object import EDGE_RADIUS_MM, ObjectBase
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.mesh_solid import MeshShape
from magicsim.geometry.shapes.revolved import Arc, ConvexProfile, Revolved
from magicsim.geometry.shapes.solids import RoundedBox, RoundedCylinder, Shape, Sphere
from magicsim.notebook.screen import from_srgb

MjModel = Any
"""`mujoco.MjModel`; its attributes are those of MuJoCo's C structure."""
MjData = Any
"""`mujoco.MjData`."""
MjSpec = Any
"""`mujoco.MjSpec`."""


def engine() -> Any:  # noqa: ANN401 -- a module
    """The package `mujoco`; `ConfigError` where it is not installed."""
    try:
        import mujoco
    except ImportError:
        msg = "magicsim.robot.mujoco needs the package mujoco, which is not installed: pip install 'magicsim[mujoco]'"
        raise ConfigError(msg) from None
    return mujoco


MM = 1000.0
"""Millimetres in a metre."""
EDGE_SHARE = 0.25
"""Radius of edges, which MuJoCo has sharp, in units of the smallest half size; at most 0.1 mm."""
SMALLEST_MM, LARGEST_MM = 0.01, 200.0
"""Least and largest extent of what may touch a sensor, as for mesh files [mm]."""
BALL_SEGMENTS = 128
KINDS = ("sphere", "capsule", "cylinder", "box", "ellipsoid", "mesh")


def rigid_part(model: MjModel, body: int) -> dict[int, Array]:
    """A body and the children that no joint moves against it, with their frames in its own, shape (4, 4) [m].

    A child without a joint is fixed to its parent; a mocap body has none and is moved by the caller all the same.
    """
    frames = {body: np.eye(4)}
    for child in range(body + 1, int(model.nbody)):  # parents come before their children
        parent = int(model.body_parentid[child])
        if parent in frames and model.body_jntnum[child] == 0 and model.body_mocapid[child] < 0:
            frames[child] = frames[parent] @ _frame(model.body_pos[child], model.body_quat[child])
    return frames


def geoms_of(model: MjModel, bodies: Iterable[int]) -> list[int]:
    """Numbers of the geoms of some bodies."""
    first, count = model.body_geomadr, model.body_geomnum
    return [geom for body in bodies for geom in range(int(first[body]), int(first[body] + count[body]))]


def _frame(position_m: Array, quaternion: Array) -> Array:
    turn, frame = np.zeros(9), np.eye(4)
    engine().mju_quat2Mat(turn, quaternion)
    frame[:3, :3], frame[:3, 3] = turn.reshape(3, 3), position_m
    return frame


def body_solid(model: MjModel, body: int, geoms: Sequence[int]) -> tuple[Shape, int | None]:
    """The union of a body's geoms, and the geom whose frame it is in; None stands for the body's frame.

    A body of one geom has that geom's exact shape; of several, the mesh of their union.

    `ConfigError` where a geom cannot press or a mesh is not closed.
    """
    if len(geoms) == 1:
        return geom_shape(model, geoms[0]), geoms[0]
    parts, frames = [], rigid_part(model, body)
    for geom in geoms:
        mesh = geom_shape(model, geom).mesh()
        frame = frames[int(model.geom_bodyid[geom])] @ _frame(model.geom_pos[geom], model.geom_quat[geom])
        vertices = mesh.vertices @ frame[:3, :3].T + MM * frame[:3, 3]
        triangles = manifold3d.Mesh64(np.ascontiguousarray(vertices), mesh.faces.astype(np.uint64))
        parts.append(manifold3d.Manifold(triangles))
    whole = manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add)
    return MeshShape.of(from_manifold(whole)), None


def geom_shape(model: MjModel, geom: int) -> Shape:
    """The solid of one geom in its own frame; `ConfigError` where it cannot press."""
    kind = engine().mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()
    name = geom_name(model, geom)
    x, y, z = (MM * model.geom_size[geom]).tolist()  # radius and half length where it is round
    match kind:
        case "sphere":
            return Sphere(x)
        case "capsule":
            ends = (
                Arc(radial_mm=0.0, axial_mm=-y, radius_mm=x, end_deg=0.0),
                Arc(radial_mm=0.0, axial_mm=y, radius_mm=x, end_deg=90.0),
            )
            return Revolved(ConvexProfile(ends), x)
        case "cylinder":
            return RoundedCylinder(x, 2 * y, "z", _edge_mm(x, y))
        case "box":
            return RoundedBox((2 * x, 2 * y, 2 * z), _edge_mm(x, y, z))
        case "ellipsoid":
            return MeshShape.of(from_manifold(manifold3d.Manifold.sphere(1.0, BALL_SEGMENTS).scale((x, y, z))))
        case "mesh":
            return _mesh_shape(model, geom, name)
    msg = f"geom '{name}' is a {kind}, which cannot press on a sensor: must be {', '.join(KINDS[:-1])} or {KINDS[-1]}"
    raise ConfigError(msg)


def geom_name(model: MjModel, geom: int) -> str:
    """A geom's name, or its number where it has none."""
    return str(model.geom(geom).name) or f"number {geom}"


def check_size(body: str, shape: Shape) -> None:
    """Refuses (`ConfigError`) a body that is too small or too large to touch a sensor, with its extents."""
    extents = [shape.support_mm(axis) + shape.support_mm(-axis) for axis in np.eye(3)]
    if min(extents) < SMALLEST_MM or max(extents) > LARGEST_MM:
        size = " x ".join(f"{each:.4g}" for each in extents)
        msg = f"body '{body}' measures {size} mm: must be {SMALLEST_MM:g} to {LARGEST_MM:g} mm to touch a sensor"
        raise ConfigError(msg)


def _mesh_shape(model: MjModel, geom: int, name: str) -> MeshShape:
    number = int(model.geom_dataid[geom])
    first, count = int(model.mesh_vertadr[number]), int(model.mesh_vertnum[number])
    first_face, faces = int(model.mesh_faceadr[number]), int(model.mesh_facenum[number])
    mesh = trimesh.Trimesh(
        MM * np.asarray(model.mesh_vert[first : first + count], np.float64),
        np.asarray(model.mesh_face[first_face : first_face + faces], np.int64),
        process=True,
    )
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        msg = f"geom '{name}': its mesh is not watertight: every edge must belong to two triangles that agree"
        raise ConfigError(msg)
    if mesh.volume < 0:
        mesh.invert()
    return MeshShape.of(SurfaceMesh(vertices=np.array(mesh.vertices, np.float64), faces=np.array(mesh.faces, np.int32)))


def _edge_mm(*half_sizes_mm: float) -> float:
    return min(EDGE_RADIUS_MM, EDGE_SHARE * min(half_sizes_mm))


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
        return solid if isinstance(solid, Sphere) else self.entered_from_above(solid, pose=pose)


def body_object(model: MjModel, body: int) -> tuple[BodyObject, int | None]:
    """A body with its rigid part as an object, and the geom whose frame it is in; None stands for the body's frame.

    Geoms that take part in MuJoCo's contacts make the solid; where there are none, all of them do. The colour is that
    of the first one, read as sRGB.

    `ConfigError` where it has no geometry, or one that cannot press, or of a size that is not allowed.
    """
    geoms = geoms_of(model, rigid_part(model, body))
    if not geoms:
        raise ConfigError(f"body '{model.body(body).name}' has no geometry to touch a sensor with: give it a geom")
    colliding = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    solid, frame = body_solid(model, body, colliding or geoms)
    check_size(model.body(body).name, solid)
    material = int(model.geom_matid[geoms[0]])
    rgba = model.geom_rgba[geoms[0]] if material < 0 else model.mat_rgba[material]
    specular = 0.0 if material < 0 else float(model.mat_reflectance[material])
    red, green, blue = np.clip(from_srgb(np.asarray(rgba[:3], np.float64)), 0, 1).tolist()
    return BodyObject(solid=solid, color=(red, green, blue), specular=specular), frame


def pose_in_sensor(data: MjData, body: int, frame: int | None, site: int) -> Pose:
    """Where an object is as a sensor at a site sees it, by the geom whose frame it is in or, for None, by its body."""
    if frame is None:
        position_m, rotation = data.xpos[body], data.xmat[body].reshape(3, 3)
    else:
        position_m, rotation = data.geom_xpos[frame], data.geom_xmat[frame].reshape(3, 3)
    turn = data.site_xmat[site].reshape(3, 3).T
    return Pose(position_mm=MM * (turn @ (position_m - data.site_xpos[site])), rotation=turn @ rotation)
