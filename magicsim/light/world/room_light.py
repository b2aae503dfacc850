"""Particles that the room sends: directions by how bright it is there, places where they can meet what is in the room.

A sensor stands in a black housing that is open below: light of the room enters through that opening, or it meets an
object first. So there are two beams, which share no line: one through the opening, which is the same whatever stands
before it, and one around the object that leaves out what the first one has (`Beam.leaves_out`). A block without a
housing is in a beam as wide as the sphere around it.

Directions are drawn from cells of equal solid angle in proportion to the flux through the beam, a share `EVEN` of them
as from an even room, so that nothing between two cells gets too much weight. The particles of Mitsuba's own `envmap`
(3.9.1) did not give the means of its path tracer.

What something that passes changes of the room's radiance, its own in front of it less that of what it hides, has either
sign, so it is no light that the renderer knows. It is asked for the radiance of directions, as an environment is, and
sends particles of its positive and of its negative part.
"""

from typing import Any, NamedTuple, Self

import numpy as np

from magicsim.arrays import Array
from magicsim.light.backend import aligned, dr, floats, in_rows, mi
from magicsim.scenes.rig import Rig
from magicsim.scenes.room import Passing

RINGS, SECTORS = 64, 128
"""Cells of equal solid angle: heights of a unit sphere, and turns around the sensor's axis."""
BEYOND = 2.0
"""How far an object counts as lit, in radii of the first beam."""
EVEN = 0.2
"""Share of the particles that are spread as an even room would."""
ON_BLOCK = 0.85
"""Share of the particles that enter the opening right below the block."""
LOOKS = 4
"""Places of a beam along each of its two sides at which a near room is looked at: it is another from each."""


class Beam(NamedTuple):
    """All lines through a disk: one that lies in the sensor's plane, or one across each direction."""

    centre: Any
    """Centre of the disk [mm]."""
    radius_mm: float
    away_mm: float
    """Distance from there at which nothing is in the way any more."""
    block_mm: tuple[float, float] | None = None
    """Half of the block's footprint, of a disk that is the opening of a housing and lets in what goes up; None where
    the disk lies across each direction."""
    leaves_out: "Beam | None" = None
    """What another beam sends already."""

    @classmethod
    def into(cls, housing: Any, block: Any) -> Self:
        """Into a housing that is open below; boxes of both."""
        low, high = np.array(housing.min), np.array(housing.max)
        centre = [*(low[:2] + high[:2]) / 2, low[2]]
        half = np.maximum(np.abs(np.array(block.min)), np.abs(np.array(block.max)))[:2]
        return cls(mi.ScalarPoint3f(*centre), float(high[0] - low[0]) / 2, 0.0, (float(half[0]), float(half[1])))

    @classmethod
    def around(cls, box: Any) -> Self:
        """Around something, from all sides."""
        sphere = box.bounding_sphere()
        return cls(sphere.center, float(sphere.radius), 0.0)

    def onto(self, target: Any) -> "Beam | None":
        """Onto what stands in the room, without what this beam sends; None where that is too far off to matter."""
        near, reach = mi.ScalarBoundingBox3f(target), BEYOND * self.radius_mm
        near.clip(mi.ScalarBoundingBox3f(self.centre - reach, self.centre + reach))
        if not near.valid():
            return None
        sphere = near.bounding_sphere()
        return Beam(sphere.center, float(sphere.radius), 2 * self.away_mm, None, self)

    @property
    def middle(self) -> Any:
        """Centre of its disk, opaque: the compiled kernel serves an object wherever it is."""
        return mi.Point3f(*(dr.opaque(mi.Float, each) for each in self.centre))

    def has(self, ray: Any) -> Any:
        """Which lines are among this beam's, mi.Bool."""
        centre, squared = self.middle, dr.opaque(mi.Float, self.radius_mm**2)
        if self.block_mm is None:
            return dr.squared_norm(dr.cross(ray.o - centre, ray.d)) <= squared
        across = ray((centre.z - ray.o.z) / ray.d.z)
        return (ray.d.z > 0) & (dr.squared_norm(across - centre) <= squared)


def room_beams(sensor: Any, block: Any, housing: Any | None, target: Any | None, others: list[Any]) -> list[Beam]:
    """The beams that together hold every line along which the room's light gets somewhere, no line in two of them."""
    first = Beam.into(housing, block) if housing is not None else Beam.around(sensor)
    boxes = [sensor, *([target] if target is not None else []), *others]
    spheres = [box.bounding_sphere() for box in boxes if box.valid()]
    needed = max(float(dr.norm(each.center - first.centre)) + float(each.radius) for each in spheres)
    # In steps, so that an object on its way does not change how places are rounded.
    away_mm = 2.0 ** np.ceil(np.log2(needed))
    first = first._replace(away_mm=away_mm)
    second = first.onto(target) if target is not None else None
    return [first] if second is None else [first, second]


def room_particles(environment: Any, beam: Beam, *, u: list[Any]) -> tuple[Any, Any]:
    """First rays of particles and their weights, from four uniform numbers each."""
    shares = floats(_shares(environment, beam))
    cell, ring_part = mi.DiscreteDistribution(shares).sample_reuse(u[0])
    height = 2 * (mi.Float(cell // SECTORS) + ring_part) / RINGS - 1
    turn = dr.two_pi * (mi.Float(cell % SECTORS) + u[1]) / SECTORS
    sine = dr.safe_sqrt(1 - dr.square(height))
    way = mi.Vector3f(-sine * dr.cos(turn), -sine * dr.sin(turn), -height)
    chance = dr.gather(mi.Float, shares, cell) * (RINGS * SECTORS / (4 * dr.pi))
    ray, area = beam_rays(beam, way, u[2], u[3])
    weight = room_towards(environment, ray) * area / chance
    if beam.leaves_out is not None:
        weight[beam.leaves_out.has(ray)] = 0
    return ray, weight


def beam_rays(beam: Beam, way: Any, right: Any, up: Any) -> tuple[Any, Any]:
    """Rays of a beam along ways, from where nothing is in the way yet, and the area that each stands for [mm2]."""
    place, area = _places(beam, way, right, up)
    away = dr.opaque(mi.Float, beam.away_mm)
    return mi.Ray3f(beam.middle + place - away * way, way), area


def _places(beam: Beam, way: Any, right: Any, up: Any) -> tuple[Any, Any]:
    """Places on the disk, from its centre, and the area across the way that each stands for [mm2]."""
    radius = dr.opaque(mi.Float, beam.radius_mm)
    if beam.block_mm is None:
        disk = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(right, up))
        return radius * mi.Frame3f(way).to_world(mi.Vector3f(*disk, 0)), dr.pi * dr.square(radius)
    half = [dr.opaque(mi.Float, each) for each in beam.block_mm]
    below = right < ON_BLOCK
    beside = radius * mi.warp.square_to_uniform_disk_concentric(mi.Point2f((right - ON_BLOCK) / (1 - ON_BLOCK), up))
    x = dr.select(below, half[0] * (2 * right / ON_BLOCK - 1), beside.x)
    y = dr.select(below, half[1] * (2 * up - 1), beside.y)
    is_beside = (dr.abs(x) > half[0]) | (dr.abs(y) > half[1])
    around = dr.select(is_beside, dr.pi * dr.square(radius) / (1 - ON_BLOCK), 0)
    area = dr.select(below, 4 * half[0] * half[1] / ON_BLOCK, around)
    return mi.Vector3f(x, y, 0), area * dr.maximum(way.z, 0)


def _shares(environment: Any, beam: Beam) -> Array:
    """Shares of the particles for each cell, ring after ring from below, shape (RINGS * SECTORS,)."""
    ring, sector = np.divmod(np.arange(RINGS * SECTORS), SECTORS)
    height, turn = 2 * (ring + 0.5) / RINGS - 1, 2 * np.pi * (sector + 0.5) / SECTORS
    sine = np.sqrt(1 - height**2)
    towards = np.stack([sine * np.cos(turn), sine * np.sin(turn), height])
    across = np.ones(len(height)) if beam.block_mm is None else np.maximum(-height, 0)
    looks = LOOKS if isinstance(environment, NearRoom) else 1
    spots = (np.mgrid[:looks, :looks].reshape(2, -1) + 0.5) / looks
    way = -mi.Vector3f(*(aligned(np.tile(each, looks**2), np.float32) for each in towards))
    right, up = (mi.Float(aligned(np.repeat(each, len(height)), np.float32)) for each in spots)
    seen = in_rows(room_towards(environment, beam_rays(beam, way, right, up)[0]), np.float32).T.sum(0)
    bright = across * np.broadcast_to(seen, looks**2 * len(height)).reshape(-1, len(height)).mean(0)
    even = across / across.sum()
    return np.asarray(EVEN * even + (1 - EVEN) * bright / bright.sum() if bright.sum() > 0 else even)


def room_towards(environment: Any, ray: Any) -> Any:
    """Radiance of what comes along rays, from behind their origins, mi.Color3f."""
    return mi.Color3f(environment.eval(missed(mi.Ray3f(ray.o, -ray.d))))


def missed(ray: Any) -> Any:
    """What rays are said to meet that meet nothing, for whatever shines from all around: their origin and direction."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.p, si.wi = ray.o, -ray.d
    return si


class NearRoom:
    """A room that is near: what shines from all around stands on a sphere around the middle of the contact face.

    A ray then sees what is where it leaves the sphere, and not what is in its direction: nearby places look at
    different parts of the picture, as they do before a bench or a wall. The sphere is matt. Nothing stands outside of
    it, so a line has one place where its light comes from, wherever on it a ray begins. It is asked as environments
    are, with the origins of the rays.
    """

    def __init__(self, far: Any, distance_mm: float) -> None:
        self._far, self._distance = far, dr.opaque(mi.Float, distance_mm)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance that arrives at `si.p` along `-si.wi`, mi.Color3f; 0 on lines that pass by the sphere."""
        ahead = dr.dot(si.p, si.wi)
        inside = dr.square(self._distance) - dr.squared_norm(si.p - ahead * si.wi)
        place = si.p - (ahead + dr.safe_sqrt(inside)) * si.wi
        seen = active & (inside > 0)
        met = dr.zeros(mi.SurfaceInteraction3f)
        met.wi = -dr.normalize(place)
        return dr.select(seen, self._far.eval(met, seen), 0)


def surroundings(far: Any, rig: Rig) -> Any:
    """What shines from all around, from as near as a rig says; None where nothing does."""
    return far if far is None or rig.near_mm is None else NearRoom(far, rig.near_mm)


class RoomPicture(mi.Texture):  # type: ignore[misc]
    """Radiance of the sphere for Mitsuba's own integrators, which meet it as a shape."""

    def __init__(self, properties: Any) -> None:
        """Reads `far`, an emitter that shines from infinitely far away."""
        super().__init__(properties)
        self._far, self._scale = properties["far"], mi.Float(1)

    def traverse(self, callback: Any) -> None:
        """Shows a factor to `mi.traverse`."""
        callback.put("value", self._scale, mi.ParamFlags.Differentiable)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance of places on the sphere."""
        met = dr.zeros(mi.SurfaceInteraction3f)
        met.wi = -dr.normalize(si.p)
        return self._scale * self._far.eval(met, active)


mi.register_texture("room_picture", RoomPicture)


def room_sphere(far: dict[str, Any], distance_mm: float) -> dict[str, Any]:
    """Entry of a black sphere in a scene's dictionary, bright inside as the emitter infinitely far away."""
    return {
        "type": "sphere",
        "radius": distance_mm,
        "flip_normals": True,
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        "emitter": {"type": "area", "radiance": {"type": "room_picture", "far": far}},
    }


SOFT = 0.2
"""Part of half its width and height over which its edges fade."""


class PassingLight:
    """The change of the room by something that can be moved."""

    def __init__(self, passing: Passing, room: Any, ambient: tuple[float, float, float]) -> None:
        own = [share * light for share, light in zip(passing.reflectance, ambient, strict=True)]
        self._room, self._color = room, mi.Color3f(*(dr.opaque(mi.Float, each) for each in own))
        numbers = (passing.distance_mm, passing.rise_mm, *(size / 2 for size in passing.size_mm))
        self.distance, self.rise, self.half_width, self.half_height = (dr.opaque(mi.Float, n) for n in numbers)
        self.middle = dr.opaque(mi.Float, 0.0)

    def place(self, x_mm: float) -> None:
        """Moves its middle along x [mm]."""
        self.middle = dr.opaque(mi.Float, x_mm)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Change of the radiance that arrives along `-si.wi`, mi.Color3f."""
        towards = -si.wi
        far = self.distance / dr.maximum(-towards.z, 1e-6)
        across = (far * towards.x - self.middle) / self.half_width
        up = (far * towards.y - self.rise) / self.half_height
        covered = dr.select(towards.z < 0, _faded(across) * _faded(up), 0)
        seen = active & (covered > 0)
        return dr.select(seen, covered * (self._color - self._room.eval(si, seen)), 0)


def _faded(share: Any) -> Any:
    """1 in the middle, 0 from 1 on, smooth between."""
    t = dr.clip((1 - dr.abs(share)) / SOFT, 0, 1)
    return t * t * (3 - 2 * t)


class PassingPart(NamedTuple):
    """The part of one sign."""

    light: PassingLight
    sign: float

    def rays(self, beam: Beam, u: list[Any]) -> tuple[Any, Any]:
        """First rays of particles, evenly over it, and their weights, 0 of the other sign; `u` is uniform."""
        half_width, half_height, distance = self.light.half_width, self.light.half_height, self.light.distance
        x = self.light.middle + (2 * u[0] - 1) * half_width
        y = self.light.rise + (2 * u[1] - 1) * half_height
        way = mi.Vector3f(-x, -y, distance)
        squared = dr.squared_norm(way)
        way = way * dr.rsqrt(squared)
        solid_angle = 4 * half_width * half_height * distance * dr.rcp(squared * dr.sqrt(squared))
        ray, area = beam_rays(beam, way, u[2], u[3])
        weight = mi.Color3f(room_towards(self.light, ray)) * (area * solid_angle)
        if beam.leaves_out is not None:
            weight[beam.leaves_out.has(ray)] = 0
        return ray, mi.Color3f(dr.maximum(self.sign * weight, 0))
