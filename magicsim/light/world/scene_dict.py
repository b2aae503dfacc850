"""What stands in a sensor's scene, as the renderer's dictionary: block, strips, lens, camera, object, room."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.film import film
from magicsim.geometry.design import Optics
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import mi
from magicsim.light.flaws.scatterers import scatterer_entries
from magicsim.light.world import names
from magicsim.light.world.finish import Finish
from magicsim.light.world.lamp_shapes import annulus, lamp_entries, marker_bsdf, marker_disks
from magicsim.light.world.materials import face_bsdf, face_places, interface_bsdf, parted
from magicsim.light.world.room_light import room_sphere
from magicsim.light.world.shapes import matt, mesh_shape, shining
from magicsim.scenes.refusals import housing_mm, opening_mm
from magicsim.scenes.rig import INSET_MM, LedStrip, Rig
from magicsim.scenes.room import room_radiance

SIDE_STEPS = 401
AIR_GAP_MM = 0.3
"""Gap between body and an LED strip behind air [mm]."""
RIM_MM = 0.1
"""Height of the opening's rim where the housing is wider above it [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldContent:
    """What is in the scene; another content is another scene."""

    object_mesh: SurfaceMesh | None
    """The object in its own frame, or None where it is left out."""
    object_finish: Finish
    flashlight: bool
    furnace: bool = False
    """White furnace: radiance 1 from all around instead of the room, in which nothing may gain or lose light."""

    @property
    def object_name(self) -> str:
        """Name of the object's shape: a ghost is none that the estimator knows."""
        return names.GHOST if self.object_finish.is_ghost else names.OBJECT


def lights_inside(rig: Rig) -> list[str]:
    """Names of the lights that shine inside the body: the strips in optical contact."""
    return [_strip_name(index) for index, strip in enumerate(rig.strips) if strip.coupling == "contact"]


UNASKED = {"type": "dielectric"}
"""Material of body and walls where the renderer's own passes know the indices: here those of a printed unit would be
literals of every kernel, compiled anew for each unit."""


def lights_off(rig: Rig) -> list[str]:
    """Names of the lights whose radiance is 0: they are there, reflect, and send out nothing."""
    off = [_strip_name(index) for index, strip in enumerate(rig.strips) if not any(strip.radiance)]
    off += [f"led{index}" for index, led in enumerate(rig.leds) if not any(led.radiance)]
    off += [names.RING] if rig.ring is not None and not any(rig.ring.radiance) else []
    return off if any(rig.flashlight.radiance) else [*off, names.FLASHLIGHT]


def _strip_name(index: int) -> str:
    return f"strip{index}"


def with_lens(body: Array, elastomer: Elastomer, rig: Rig) -> Array:
    """Body vertices with the lens side moved out by the bonded, index-matched lens plate."""
    top = elastomer.body.vertices[:, 2] > elastomer.design.height_mm - 1e-9
    moved = body.copy()
    moved[top, 2] += rig.lens.thickness_mm
    return moved


def block_shapes(elastomer: Elastomer, rig: Rig, *, for_paths: bool = False) -> dict[str, Any]:
    """Body, with the lens plate, and infill at rest, by name.

    For Mitsuba's own integrators (`for_paths`) rough interfaces have materials, and a special contact face is a shape
    of its own.
    """
    materials, roughness = elastomer.design.materials, elastomer.design.roughness
    body_medium = medium_of(materials.body)
    body, placed = elastomer.body, with_lens(elastomer.body.vertices, elastomer, rig)
    top_mm = elastomer.design.height_mm
    bare = interface_bsdf(materials.body.ior, 1.0, roughness.skin, top_mm) if for_paths else UNASKED
    shapes = {}
    if for_paths and elastomer.design.face_is_special:
        body, face = parted(elastomer)
        material, texture = face_bsdf(elastomer), face_places(elastomer)
        face = replace(face, vertices=placed)
        shapes[names.FACE] = mesh_shape(face, names.FACE, material, interior=body_medium, texture=texture)
    shapes[names.BODY] = mesh_shape(replace(body, vertices=placed), names.BODY, bare, interior=body_medium)
    if elastomer.infill is not None and materials.infill is not None:
        infill, medium, cells, fused = materials.infill, medium_of(materials.infill), elastomer.infill, elastomer.fused
        if fused is not None:
            cells = replace(cells, faces=fused.without_membranes if for_paths else fused.faces)
        walls = interface_bsdf(infill.ior, materials.body.ior, roughness.walls, top_mm) if for_paths else UNASKED
        shapes[names.INFILL] = mesh_shape(cells, names.INFILL, walls, interior=medium, exterior=body_medium)
        if for_paths and elastomer.inclusions is not None:
            inclusions = elastomer.inclusions.placed(elastomer.infill.vertices)
            reflectance = elastomer.design.inclusions.flake_reflectance
            shapes |= scatterer_entries(inclusions, infill.ior, reflectance, medium)
    return shapes


def in_group(shapes: dict[str, Any]) -> dict[str, Any]:
    """Entries of shapes that share a search tree of their own.

    The renderer builds the tree of a group faster than that of a scene, in which it splits triangles: of 190,000
    triangles in 60 to 90 instead of 170 to 230 ms. Rays through the block then take a tenth to a quarter longer.
    """
    return {
        names.BLOCK: {"type": "shapegroup", **shapes},
        names.PLACE: {"type": "instance", "group": {"type": "ref", "id": names.BLOCK}},
    }


def scene_dict(
    elastomer: Elastomer, rig: Rig, content: WorldContent, block: dict[str, Any], *, for_paths: bool = False
) -> dict[str, Any]:
    """Everything at rest, the object where its own frame puts it."""
    scene: dict[str, Any] = {"type": "scene", "sensor": _camera(elastomer, rig), **block}
    for index, strip in enumerate(rig.strips):
        scene[_strip_name(index)] = strip_entry(strip, elastomer)
    if rig.leds or rig.ring is not None:
        scene |= lamp_entries(rig, elastomer.design.height_mm + rig.lens.thickness_mm)
    if (disks_below := marker_disks(elastomer.design)) is not None:
        scene[names.MARKERS] = mesh_shape(disks_below, names.MARKERS, marker_bsdf(elastomer.design))
    if content.flashlight:
        scene[names.FLASHLIGHT] = flashlight_entry(rig)
    if content.furnace:
        scene[names.ENVIRONMENT] = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    elif max(rig.room_light) > 0 and not elastomer.design.is_opaque:
        scene |= _room(elastomer, rig, for_paths=for_paths)
    if content.object_mesh is not None:
        scene[content.object_name] = mesh_shape(content.object_mesh, content.object_name, content.object_finish.bsdf())
    return scene


def medium_of(optics: Optics) -> Any:
    """A material as the renderer's medium, None where it is clear."""
    sigma_t = optics.sigma_s_per_mm + optics.absorption_per_mm
    if sigma_t == 0:
        return None
    phase = {"type": "hg", "g": optics.anisotropy} if optics.anisotropy else {"type": "isotropic"}
    # Next-event estimation is blocked by the dielectric walls, so sampling emitters would only cost time.
    return mi.load_dict(
        {
            "type": "homogeneous",
            "albedo": optics.sigma_s_per_mm / sigma_t,
            "sigma_t": sigma_t,
            "phase": phase,
            "sample_emitters": False,
        }
    )


def _camera(elastomer: Elastomer, rig: Rig) -> dict[str, Any]:
    ideal = film(elastomer.design, rig.lens, rig.camera)
    pinhole = elastomer.design.height_mm + rig.lens.thickness_mm + rig.camera.distance_mm
    return {
        "type": "perspective",
        "fov": ideal.fov_deg,
        "fov_axis": "x",
        "near_clip": 0.1,
        "far_clip": 1e4,
        "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, pinhole], target=[0, 0, 0], up=[0, 1, 0]),
        "film": {
            "type": "hdrfilm",
            "width": ideal.columns,
            "height": ideal.rows,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }


def strip_entry(strip: LedStrip, elastomer: Elastomer) -> dict[str, Any]:
    """Entry of an LED strip in a scene's dictionary: a rectangle along its side of the block."""
    width, length = elastomer.design.footprint_mm
    height = elastomer.design.height_mm
    sign = 1.0 if strip.side[0] == "+" else -1.0
    offset = -INSET_MM if strip.coupling == "contact" else AIR_GAP_MM
    low = _side_rise_mm(strip, elastomer)
    middle, half_height = (low + height) / 2, max((height - low) / 2 - strip.margin_mm, 0.1 * (height - low))
    vertical = np.array([0.0, 0.0, half_height])
    if strip.side[1] == "x":
        along = np.array([0.0, length / 2 - strip.margin_mm, 0.0])
        center, normal = np.array([sign * (width / 2 + offset), 0, middle]), np.array([-sign, 0.0, 0.0])
    else:
        along = np.array([width / 2 - strip.margin_mm, 0.0, 0.0])
        center, normal = np.array([0, sign * (length / 2 + offset), middle]), np.array([0.0, -sign, 0.0])
    if np.dot(np.cross(along, vertical), normal) < 0:
        along = -along
    to_world = np.eye(4)
    to_world[:3] = np.stack([along, vertical, normal, center], 1)
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(to_world),
        "bsdf": matt(strip.reflectance),
        "emitter": shining(strip.radiance),
    }


def _side_rise_mm(strip: LedStrip, elastomer: Elastomer) -> float:
    """Highest place of the contact face along the side of a strip, which stays inside the block [mm]."""
    design = elastomer.design
    if design.face is None:
        return 0.0
    axis, sign = "xy".index(strip.side[1]), 1.0 if strip.side[0] == "+" else -1.0
    half = np.array(design.footprint_mm) / 2
    places = np.zeros((SIDE_STEPS, 2))
    places[:, axis], places[:, 1 - axis] = sign * half[axis], np.linspace(-half[1 - axis], half[1 - axis], SIDE_STEPS)
    return float(design.rise_mm(places).max())


def _room(elastomer: Elastomer, rig: Rig, *, for_paths: bool) -> dict[str, Any]:
    """Light from all around, and a black housing that leaves what is below the contact face.

    Where lights stand beside its opening it is wider above a rim: as much of the room's light enters.
    """
    opening, (radius, top) = opening_mm(elastomer.design), housing_mm(elastomer.design, rig)
    far, near_mm = _environment(rig), rig.near_mm
    black = {"type": "twosided", "bsdf": matt(0.0)}
    lid = mi.ScalarTransform4f().translate([0, 0, top]).scale([radius, radius, 1])

    def wall(low: float, high: float, radius: float) -> dict[str, Any]:
        return {"type": "cylinder", "p0": [0, 0, low], "p1": [0, 0, high], "radius": radius, "bsdf": black}

    found = {
        names.ENVIRONMENT: far if near_mm is None or not for_paths else room_sphere(far, near_mm),
        names.HOUSING: wall(0, top if radius == opening else RIM_MM, opening),
        "lid": {"type": "disk", "to_world": lid, "bsdf": black},
    }
    if radius > opening:
        shoulder = annulus((opening + radius) / 2, radius - opening, RIM_MM)
        found |= {names.SHELL: wall(RIM_MM, top, radius), names.SHOULDER: mesh_shape(shoulder, names.SHOULDER, black)}
    return found


def _environment(rig: Rig) -> dict[str, Any]:
    if rig.room is None:
        return {"type": "constant", "radiance": {"type": "rgb", "value": list(rig.ambient)}}
    radiance = (room_radiance(rig.room) * rig.ambient).astype(np.float32)
    # The renderer's images have -z at their edges.
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {"type": "envmap", "bitmap": mi.Bitmap(radiance), "to_world": turned}


def flashlight_place(rig: Rig, shift_x_mm: float) -> Any:
    """Where the flashlight is, shifted along x [mm]."""
    light = rig.flashlight
    place = mi.ScalarTransform4f().translate([light.x_mm + shift_x_mm, light.y_mm, -light.distance_mm])
    return place.scale([light.radius_mm, light.radius_mm, 1.0])


def flashlight_entry(rig: Rig) -> dict[str, Any]:
    """Entry of the flashlight in a scene's dictionary: a disk that shines and reflects nothing."""
    return {
        "type": "disk",
        "to_world": flashlight_place(rig, 0.0),
        "bsdf": matt(0.0),
        "emitter": shining(rig.flashlight.radiance),
    }
