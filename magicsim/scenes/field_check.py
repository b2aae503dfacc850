"""What a scene shows or presses beside its block: allowed, and seldom meant.

A camera that sees past the block shows its side faces and the strips along them. An object larger than the contact face
reaches over it, and where it presses on the rim, contact beside the face is left out. The mesh of a file keeps the
file's origin, which may be far from it.
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.projection import focal_px, landing_mm
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.scenes.refusals import object_problem
from magicsim.scenes.scene import SceneConfig

RIM_POINTS = 64
"""Points along each edge of the contact face at which an object is looked for."""
AXES = ("x", "y")


def field_warnings(scene: SceneConfig) -> list[str]:
    """A line for each target that does not fit the block; `ConfigError` where the object's file is missing."""
    return [*_view(scene), *_object(scene)]


def check_room(scene: SceneConfig) -> None:
    """Refuses (`ConfigError`) an object that would be outside of a near room at a keyframe, or has no file."""
    target = scene.object
    if scene.rig.near_mm is None or target is None or scene.design.is_opaque:
        return
    vertices = target.surface().vertices
    for frame, placed in _places(scene):
        problem = object_problem(scene.rig, placed.pose.to_sensor(vertices))
        if problem is not None:
            raise ConfigError(f"keyframe {frame}: {problem}")


def _places(scene: SceneConfig) -> list[tuple[int, Indenter]]:
    """Frame of each keyframe with an object, and the object there."""
    target = scene.object
    return [
        (
            at.frame,
            place_object(
                target, gap_mm=at.gap_mm, x_mm=at.x_mm, y_mm=at.y_mm, twist_deg=at.twist_deg, design=scene.design
            ),
        )
        for at in scene.keyframes
        if target is not None and at.gap_mm is not None
    ]


def _view(scene: SceneConfig) -> list[str]:
    reach = _reach_mm(scene)
    past = reach - np.array(scene.design.footprint_mm) / 2
    if past.max() <= 0:
        return []
    camera, fits = scene.rig.camera, float((np.array(scene.design.footprint_mm) / 2 / reach).min())
    ways = " and ".join(
        f"{over:.2g} mm past the edge along {axis}" for axis, over in zip(AXES, past, strict=True) if over > 0
    )
    size = " x ".join(f"{each:g}" for each in scene.design.footprint_mm)
    width = np.floor(camera.field_mm * fits * 10) / 10
    return [
        f"the camera sees past the block of {size} mm: {ways}; rig.camera.field_mm = {width:g} (now "
        f"{camera.field_mm:g}) stays inside"
    ]


def _reach_mm(scene: SceneConfig) -> Array:
    """Farthest that the corner pixels read out look along x and y, distortion left out, shape (2,) [mm]."""
    camera, window = scene.rig.camera, scene.rig.camera.window
    middle = np.array([camera.columns - 1, camera.rows - 1]) / 2 + camera.principal_offset_px
    low = np.array([window.column, window.row])
    corners = np.stack([low, low + np.array([window.columns - 1, window.rows - 1])])
    slopes = (corners - middle) / focal_px(scene.design, scene.rig.lens, scene.rig.camera)
    # Rays in the planes x = 0 and y = 0, which refract the least and land the farthest.
    straight = landing_mm(slopes * np.eye(2)[:, None], scene.design, scene.rig.lens, scene.rig.camera)
    return np.asarray(np.abs(np.diagonal(straight, axis1=0, axis2=2)).max(0))


def _object(scene: SceneConfig) -> list[str]:
    places = _places(scene)
    if not places:
        return []
    face = np.array(scene.design.footprint_mm)
    low, high = np.array([[each[:2] for each in pose.box_mm()] for _, pose in places]).transpose(1, 0, 2)
    extents, found = high[0] - low[0], []
    if (extents > face).any():
        sizes = [" x ".join(f"{each:.3g}" for each in size) for size in (extents, face)]
        found.append(
            f"the object is larger than the sensor: {sizes[0]} mm before a contact face of {sizes[1]} mm; only what "
            "lies before the face is felt"
        )
    if ((low > face / 2) | (high < -face / 2)).any(1).all():
        ends = [f"{a:.4g} to {b:.4g} mm along {axis}" for a, b, axis in zip(low[0], high[0], AXES, strict=True)]
        found.append(
            f"the object is never before the contact face: at keyframe {places[0][0]} it lies at {' and '.join(ends)}; "
            "x_mm and y_mm place its origin, which of a mesh is that of its file"
        )
    rim = _rim_mm(scene.design)
    over = [frame for frame, pose in places if (pose.distance(rim)[0] < 0).any()]
    if over:
        found.append(
            f"the object presses on the rim of the contact face from keyframe {over[0]} on: what presses beside the "
            "face is left out, so forces are too small there"
        )
    return found


def _rim_mm(design: ElastomerDesign) -> Array:
    """Points on the edges of the undeformed contact face, shape (4 RIM_POINTS, 3) [mm]."""
    along = np.linspace(-0.5, 0.5, RIM_POINTS)
    half = np.full(RIM_POINTS, 0.5)
    places = np.stack([np.concatenate([along, along, half, -half]), np.concatenate([half, -half, along, along])], -1)
    places *= design.footprint_mm
    return np.column_stack([places, design.rise_mm(places)])
