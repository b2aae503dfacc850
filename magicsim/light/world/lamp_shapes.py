"""Single LEDs, rings and markers as the renderer's shapes."""

from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.markers import DotMarkers
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import dr, mi
from magicsim.light.world.names import RING
from magicsim.light.world.shapes import matt, mesh_shape, shining
from magicsim.scenes.rig import LedRing, Rig

SIDES = 24
"""Corners of a disk; its area is kept."""
RING_SIDES = 96


def led_name(index: int) -> str:
    """Name of an LED's shape and light."""
    return f"led{index}"


def lamp_entries(rig: Rig, plate_mm: float) -> dict[str, Any]:
    """Entries of LEDs and ring in a scene's dictionary, by name; the lens plate's outer face is at `plate_mm`."""
    entries: dict[str, Any] = {}
    for index, led in enumerate(rig.leds):
        disk = disks(np.array([led.place_mm]), np.array(led.axis), led.radius_mm)
        entries[led_name(index)] = _emitting(disk, led_name(index), led.radiance, led.lobe)
    if rig.ring is not None:
        entries[RING] = _emitting(ring_mesh(rig.ring, plate_mm), RING, rig.ring.radiance, rig.ring.lobe)
    return entries


def ring_mesh(ring: LedRing, plate_mm: float) -> SurfaceMesh:
    """The emitting surface of a ring, facing the block."""
    z = plate_mm + ring.gap_mm
    if ring.leds:
        angle = 2 * np.pi * np.arange(ring.leds) / ring.leds
        places = ring.radius_mm * np.stack([np.cos(angle), np.sin(angle)], 1)
        return disks(np.column_stack([places, np.full(len(places), z)]), np.array([0.0, 0.0, -1.0]), ring.width_mm / 2)
    return annulus(ring.radius_mm, ring.width_mm, z)


def annulus(radius_mm: float, width_mm: float, z: float) -> SurfaceMesh:
    """An even ring across z at that height, of a mean radius and a width, that faces down [mm]."""
    angle = 2 * np.pi * np.arange(RING_SIDES) / RING_SIDES
    around = np.stack([np.cos(angle), np.sin(angle)], 1) * np.sqrt(
        2 * np.pi / RING_SIDES / np.sin(2 * np.pi / RING_SIDES)
    )
    radii = radius_mm + np.array([-0.5, 0.5]) * width_mm
    vertices = np.concatenate([np.column_stack([radius * around, np.full(RING_SIDES, z)]) for radius in radii])
    inner = np.arange(RING_SIDES)
    following = (inner + 1) % RING_SIDES
    outer, beyond = inner + RING_SIDES, following + RING_SIDES
    faces = np.concatenate([np.stack([inner, following, beyond], 1), np.stack([inner, beyond, outer], 1)])
    return SurfaceMesh(vertices=vertices, faces=faces.astype(np.int32))


def _emitting(mesh: SurfaceMesh, name: str, radiance: tuple[float, float, float], lobe: float) -> Any:
    light = shining(radiance) if lobe == 1 else shining(radiance, "lobe", exponent=lobe)
    return mesh_shape(mesh, name, matt(0.0), emitter=mi.load_dict(light))


class LobeLight(mi.Emitter):  # type: ignore[misc]
    """A surface whose intensity falls with a power of the cosine from its normal."""

    def __init__(self, properties: Any) -> None:
        """Reads `radiance` along the normal, and `exponent` of the intensity."""
        super().__init__(properties)
        self.radiance = properties.get_emissive_texture("radiance", 1.0)
        self.exponent = properties["exponent"]
        self.m_flags = mi.EmitterFlags.Surface

    def traverse(self, callback: Any) -> None:
        """Shows the radiance to `mi.traverse`."""
        callback.put("radiance", self.radiance, mi.ParamFlags.Differentiable)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance towards where a ray came from."""
        cosine = mi.Frame3f.cos_theta(si.wi)
        return dr.select(active & (cosine > 0), self.radiance.eval(si, active) * self._fall(cosine), 0)

    def sample_ray(self, time: Any, sample1: Any, sample2: Any, sample3: Any, active: Any = True) -> tuple[Any, Any]:
        """A ray that it sends out, and its weight."""
        del sample1
        place = self.get_shape().sample_position(time, sample2, active)
        cosine = dr.power(1 - sample3.x, 1 / (self.exponent + 1))
        sine, azimuth = dr.safe_sqrt(1 - dr.square(cosine)), dr.two_pi * sample3.y
        local = mi.Vector3f(sine * dr.cos(azimuth), sine * dr.sin(azimuth), cosine)
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.p, si.n, si.sh_frame, si.time = place.p, place.n, mi.Frame3f(place.n), time
        weight = self.radiance.eval(si, active) * (dr.two_pi / (place.pdf * (self.exponent + 1)))
        return si.spawn_ray(si.to_world(local)), weight

    def sample_direction(self, it: Any, sample: Any, active: Any = True) -> tuple[Any, Any]:
        """A direction from a place towards it, and radiance over density."""
        ds = self.get_shape().sample_direction(it, sample, active)
        found = active & (ds.pdf > 0) & (dr.dot(ds.d, ds.n) < 0)
        ds.emitter = mi.EmitterPtr(self)
        return ds, dr.select(found, self.eval_direction(it, ds, found) / ds.pdf, 0)

    def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
        """Density of that direction."""
        return dr.select(active & (dr.dot(ds.d, ds.n) < 0), self.get_shape().pdf_direction(it, ds, active), 0)

    def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
        """Radiance along that direction."""
        del it
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.p, si.n, si.sh_frame, si.uv = ds.p, ds.n, mi.Frame3f(ds.n), ds.uv
        return self.radiance.eval(si, active) * self._fall(-dr.dot(ds.d, ds.n))

    def _fall(self, cosine: Any) -> Any:
        return dr.power(dr.maximum(cosine, 0), self.exponent - 1)

    def bbox(self) -> Any:
        """Bounding box of its surface."""
        return self.get_shape().bbox()


mi.register_emitter("lobe", LobeLight)


def brightest_weight(emitter: Any) -> float:
    """Weight of a particle of a surface that shines, in its brightest channel: its flux [mm2]."""
    exponent = float(emitter.exponent) if isinstance(emitter, LobeLight) else 1.0
    radiance = np.array(mi.traverse(emitter)["radiance.value"], float).max()
    return float(radiance * np.array(emitter.get_shape().surface_area()).max() * 2 * np.pi / (exponent + 1))


def disks(centres_mm: Array, axis: Array, radius_mm: float) -> SurfaceMesh:
    """Flat disks that face along an axis, each a regular polygon of the circle's area."""
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    corner = radius_mm * np.sqrt(2 * np.pi / SIDES / np.sin(2 * np.pi / SIDES))
    rim = corner * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * np.cross(axis, u))
    local = np.concatenate([np.zeros((1, 3)), rim])
    fan = np.stack([np.zeros(SIDES), 1 + np.arange(SIDES), 1 + (np.arange(SIDES) + 1) % SIDES], 1).astype(np.int32)
    first = np.arange(len(centres_mm), dtype=np.int32) * len(local)
    return SurfaceMesh(
        vertices=(centres_mm[:, None] + local).reshape(-1, 3),
        faces=(first[:, None, None] + fan).reshape(-1, 3).astype(np.int32),
    )


def marker_disks(design: ElastomerDesign) -> SurfaceMesh | None:
    """Disks of all markers at rest, facing the contact face, or None where there are none below it."""
    markers = design.markers
    if not isinstance(markers, DotMarkers) or markers.depth_mm == 0:
        return None
    places = markers.centres_mm(design.footprint_mm)
    centres = design.lifted(np.column_stack([places, np.full(len(places), markers.depth_mm)]))
    return disks(centres, np.array([0.0, 0.0, -1.0]), markers.diameter_mm / 2)


def marker_bsdf(design: ElastomerDesign) -> dict[str, Any]:
    """Entry of their material in a scene's dictionary."""
    assert isinstance(design.markers, DotMarkers)
    return {"type": "twosided", "bsdf": matt(list(design.markers.color))}
