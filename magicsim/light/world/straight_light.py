"""Light that comes to a place within the body from a lamp on a way that needs no search.

The body is a box whose lens face and sides mirror: its lamps shine straight, and by one reflection at most at the lens
face, at a side along x and at one along y, in any order. What is mirrored is what the place's mirror image sees.

A strip within the body is a rectangle. Points on it that are even in the solid angle that it fills (Ureña, Fajardo and
King 2013, *An Area-Preserving Parametrization for Spherical Rectangles*) leave an integrand that is smooth and bounded,
however near the strip is. To a lamp above the lens face a ray is refracted: where it crosses the face follows from
Snell's law in the plane of both points.
"""

from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.light.backend import aligned, columns, dr, floats, mi
from magicsim.light.world.lamp_shapes import LobeLight
from magicsim.light.world.medium import Constants, scattering_stretch
from magicsim.light.world.shapes import lights, mesh_of, shape_named

SHORT_OF_LIGHT = 1 - 1e-4
"""Part of the way to a light on which nothing may stand."""
OFF_MM = 1e-4
"""How near to the lens face a hit counts as on it [mm]."""
CLEAR_MM = 0.02
"""How far off a mirror nothing is looked for [mm]: sides bulge by less where something presses."""
NEWTON_STEPS = 6
"""To where a ray crosses the lens face: exact to single precision from the paraxial guess."""
ALONG, ACROSS = 8, 4
"""Gauss points along and across a strip."""
LEAST = 1e-9
LENS, SIDES = (0, 1), (0, -1, 1)
"""Mirrors at which a way may turn: none or the lens face; none or one of two sides."""


@dataclass(slots=True, kw_only=True)
class Arriving:
    """What comes to places from one point of a lamp each; every field is a Dr.Jit array over places."""

    direction: Any
    """Towards where it comes from, a unit vector."""
    light: Any
    """Radiance times the solid angle that the point stands for, what interfaces and media leave of it, mi.Color3f."""
    legs: list[tuple[Any, Any]]
    """Rays and lengths on which nothing may stand."""

    def unblocked(self, scene: Any, active: Any) -> Any:
        """Whether nothing stands in its way, mi.Bool."""
        clear = active & (dr.max(self.light) > 0)
        for ray, length in self.legs:
            tested, there = mi.Ray3f(ray), length > 0
            tested.maxt = length * SHORT_OF_LIGHT
            clear &= ~(scene.ray_test(tested, clear & there) & there)
        return clear


@dataclass(slots=True, kw_only=True)
class Box:
    """The body as a box of mirrors, and what is on the way through it; on the renderer's side."""

    height_mm: Any
    """Height of the flat lens face [mm]."""
    half_mm: tuple[Any, Any]
    """Half of its size along x and y [mm]."""
    constants: Constants

    def kept(self, ray: Any, length: Any) -> Any:
        """Part of light that comes along a ray within the body."""
        body = self.constants.body
        _, stretch = scattering_stretch(ray, length, self.constants.top_mm)
        return dr.exp(-body.sigma_t * stretch - body.sigma_a * (length - stretch))

    def image(self, place: Any, turns: Any) -> Any:
        """The place as its mirrors show it; `turns` has -1, 0 or 1 along each axis: the mirror, 0 without."""
        planes = self._planes(turns)
        return mi.Point3f(*[
            dr.select(turns[axis] == 0, place[axis], 2 * planes[axis] - place[axis]) for axis in range(3)
        ])  # fmt: skip

    def _planes(self, turns: Any) -> list[Any]:
        return [turns[0] * self.half_mm[0], turns[1] * self.half_mm[1], self.height_mm]

    def ways(self, image: Any, direction: Any, distance: Any, turns: Any) -> tuple[Any, list[tuple[Any, Any]]]:
        """Share of the light on the way from an image, 0 where it misses a mirror, and rays and lengths of the legs."""
        planes, share = self._planes(turns), mi.Float(1)
        at, present = [], []
        for axis in range(3):
            there = turns[axis] != 0
            steep = dr.abs(direction[axis])
            met = (planes[axis] - image[axis]) / dr.mulsign(dr.maximum(steep, LEAST), direction[axis])
            share *= dr.select(there, mi.fresnel(-steep, self.constants.body_ior)[0], 1)
            share = dr.select(there & ((met <= 0) | (met >= distance)), 0, share)
            at.append(dr.select(there, met, 0))
            present.append(there)
        low, high = dr.minimum(at[0], at[1]), dr.maximum(at[0], at[1])
        middle, last = dr.minimum(high, at[2]), dr.maximum(high, at[2])
        first, middle = dr.minimum(low, middle), dr.maximum(low, middle)
        stops, legs = [mi.Float(0), first, middle, last, distance], []
        for begin, end in pairwise(stops):
            half = (begin + end) / 2
            start = dr.select(begin > 0, begin + CLEAR_MM, 0)
            point, way = image + direction * start, mi.Vector3f(direction)
            for axis in range(3):
                before = present[axis] & (half < at[axis])
                point[axis] = dr.select(before, 2 * planes[axis] - point[axis], point[axis])
                way[axis] = dr.select(before, -way[axis], way[axis])
            ray = mi.Ray3f(point, way)
            share *= self.kept(ray, end - begin)
            legs.append((ray, end - start - dr.select(end < distance, CLEAR_MM, 0)))
        return share, legs

    def crossing(self, place: Any, point: Any) -> tuple[Any, Any]:
        """Where light from a point above the lens face to a place below it crosses that, and how far along [mm]."""
        below, above = self.height_mm - place.z, point.z - self.height_mm
        away = mi.Vector2f(point.x - place.x, point.y - place.y)
        reach = dr.maximum(dr.norm(away), 1e-6)
        ior = self.constants.body_ior
        at = reach * below / (below + ior * above)
        for _ in range(NEWTON_STEPS):
            inner, outer = dr.square(at) + dr.square(below), dr.square(reach - at) + dr.square(above)
            miss = ior * at * dr.rsqrt(inner) - (reach - at) * dr.rsqrt(outer)
            slope = ior * dr.square(below) * dr.rsqrt(inner) / inner + dr.square(above) * dr.rsqrt(outer) / outer
            at = dr.clip(at - miss / slope, 0, reach)
        step = away * (at / reach)
        return mi.Point3f(place.x + step.x, place.y + step.y, self.height_mm), at


@dataclass(slots=True, kw_only=True)
class Strips:
    """Matt rectangles within the body, each on all its ways; one row for each pair."""

    corners: Any
    along: Any
    across: Any
    normals: Any
    radiance: Any
    turns: Any
    """Mirrors of each row, mi.Vector3f."""
    straight: list[int]
    """Rows that turn at no side."""
    rows: int

    @classmethod
    def of(cls, shapes: list[tuple[Any, Array]]) -> "Strips":
        """Rectangles of the scene with their radiances."""
        table: list[list[float]] = []
        straight: list[int] = []
        for shape, radiance in shapes:
            matrix = np.array(mi.traverse(shape)["to_world"].matrix, float).reshape(4, 4)
            u, v, middle = matrix[:3, 0], matrix[:3, 1], matrix[:3, 3]
            normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
            for x, y, z in product(SIDES, SIDES, LENS):
                straight += [len(table)] if x == y == 0 else []
                table.append([*(middle - u - v), *(2 * u), *(2 * v), *normal, *radiance, x, y, z])
        found = np.array(table).reshape(-1, 6, 3)
        parts = [mi.Vector3f(*columns(found[:, part])) for part in (0, 1, 2, 3, 5)]
        return cls(
            corners=parts[0], along=parts[1], across=parts[2], normals=parts[3], turns=parts[4],
            radiance=mi.Color3f(*columns(found[:, 4])), straight=straight, rows=len(table),
        )  # fmt: skip

    def nodes(self, along: int = ALONG, across: int = ACROSS) -> Array:
        """Gauss points over the unit square, and their weights, shape (nodes, 3)."""
        (u, a), (v, b) = (np.polynomial.legendre.leggauss(count) for count in (along, across))
        places = np.stack(np.meshgrid((u + 1) / 2, (v + 1) / 2, indexing="ij"), -1).reshape(-1, 2)
        return np.column_stack([places, np.outer(a, b).ravel() / 4])

    def arriving(self, row: Any, place: Any, sample: Any, box: Box) -> Arriving:
        """From the point of a sample, an even density in the solid angle."""
        corner, along, across, normal, turns = (
            dr.gather(mi.Vector3f, each, row)
            for each in (self.corners, self.along, self.across, self.normals, self.turns)
        )
        image = box.image(place, turns)
        point, angle = rectangle_point(corner - mi.Vector3f(image), along, across, sample)
        distance = dr.norm(point)
        direction = point / distance
        share, legs = box.ways(image, direction, distance, turns)
        share *= dr.select(dr.dot(direction, normal) < 0, angle, 0)
        back = mi.Vector3f(*[dr.select(turns[k] == 0, direction[k], -direction[k]) for k in range(3)])
        return Arriving(direction=back, light=dr.gather(mi.Color3f, self.radiance, row) * share, legs=legs)


@dataclass(slots=True, kw_only=True)
class Lamps:
    """Lamps above the lens face, in triangles; one row for each pair of sides that may mirror."""

    corners: list[Any]
    """The corners of each triangle, mi.Point3f [mm]."""
    normals: Any
    areas: Any
    exponents: Any
    """Power of the cosine that the intensity falls with."""
    radiance: Any
    count: int
    turns: Any
    """Mirrors of each row, mi.Vector3f."""
    straight: list[int]
    rows: int

    @classmethod
    def of(cls, shapes: list[tuple[Any, Array]]) -> "Lamps":
        """Meshes of the scene with their radiances."""
        corners, exponents, radiance = [], [], []
        for shape, bright in shapes:
            mesh, emitter = mesh_of(shape), shape.emitter()
            corners.append(mesh.vertices[mesh.faces])
            exponents += [float(emitter.exponent) if isinstance(emitter, LobeLight) else 1.0] * len(mesh.faces)
            radiance.append(np.repeat(bright[None], len(mesh.faces), 0))
        places = np.concatenate(corners)
        cross = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
        double = np.linalg.norm(cross, axis=1)
        turns = np.array([[x, y, 0.0] for x, y in product(SIDES, SIDES)])
        return cls(
            corners=[mi.Point3f(*columns(each)) for each in places.swapaxes(0, 1)],
            normals=mi.Vector3f(*columns(cross / double[:, None])), areas=mi.Float(aligned(double / 2, np.float32)),
            exponents=floats(np.array(exponents)), count=len(places), rows=len(turns),
            radiance=mi.Color3f(*columns(np.concatenate(radiance))), turns=mi.Vector3f(*columns(turns)), straight=[0],
        )  # fmt: skip

    def nodes(self) -> Array:
        """The middle of each triangle, and its weight, shape (nodes, 3)."""
        places = (np.arange(self.count) + 1 / 3) / self.count
        return np.column_stack([places, np.full(self.count, 1 / 3), np.full(self.count, 1 / self.count)])

    def arriving(self, row: Any, place: Any, sample: Any, box: Box) -> Arriving:
        """From a point of the triangle that the sample's first part tells, all triangles alike."""
        turns = dr.gather(mi.Vector3f, self.turns, row)
        triangle = dr.minimum(mi.UInt32(sample.x * self.count), self.count - 1)
        a, b, c = (dr.gather(mi.Point3f, each, triangle) for each in self.corners)
        # Uniform over a triangle: the square folded along its diagonal.
        right, up = sample.x * self.count - mi.Float(triangle), sample.y
        folded = right + up > 1
        right, up = dr.select(folded, 1 - right, right), dr.select(folded, 1 - up, up)
        point = a + right * (b - a) + up * (c - a)
        normal, area = dr.gather(mi.Vector3f, self.normals, triangle), dr.gather(mi.Float, self.areas, triangle)
        image = box.image(place, turns)
        crossing, at = box.crossing(image, point)
        first, second = dr.norm(crossing - image), dr.norm(point - crossing)
        inside, outside = (crossing - image) / first, (point - crossing) / dr.maximum(second, LEAST)
        reach, ior = dr.norm(mi.Vector2f(point.x - image.x, point.y - image.y)), box.constants.body_ior
        below, above = box.height_mm - image.z, point.z - box.height_mm
        # Solid angle within the body for each area of the level plane of the point.
        spread = below / dr.square(inside.z) + above / dr.square(outside.z) * ior * inside.z / outside.z
        turn = dr.select(reach > 1e-3, at / dr.maximum(reach, LEAST), below / (below + ior * above))  # noqa: PLR2004
        facing = -dr.dot(outside, normal)
        there = (above > 0) & (facing > 0)
        there &= (dr.abs(crossing.x) < box.half_mm[0]) & (dr.abs(crossing.y) < box.half_mm[1])
        share, legs = box.ways(image, inside, first, turns)
        share *= (1 - mi.fresnel(-inside.z, ior)[0]) * dr.square(ior) * turn / (first * spread)
        exponent = dr.gather(mi.Float, self.exponents, triangle)
        share *= area * self.count * dr.power(dr.maximum(facing, LEAST), exponent) / outside.z
        beyond = mi.Ray3f(crossing + outside * CLEAR_MM, outside)
        back = mi.Vector3f(*[dr.select(turns[k] == 0, inside[k], -inside[k]) for k in range(3)])
        light = dr.gather(mi.Color3f, self.radiance, triangle) * dr.select(there, share, 0)
        return Arriving(direction=back, light=light, legs=[*legs, (beyond, second - CLEAR_MM)])


def straight_lights(scene: Any, inside: tuple[str, ...], above_mm: float) -> list[Strips | Lamps]:
    """Lights that are asked for by themselves: strips within the body, and what stands above the lens face."""
    strips, lamps = [], []
    for name in lights(scene):
        shape = shape_named(scene, name)
        if shape is not None:
            value = np.array(mi.traverse(shape.emitter())["radiance.value"], float).ravel()
            radiance = np.broadcast_to(value, 3)
            if name in inside:
                strips.append((shape, radiance))
            elif shape.is_mesh() and shape.bbox().max.z > above_mm:
                lamps.append((shape, radiance))
    return [*([Strips.of(strips)] if strips else []), *([Lamps.of(lamps)] if lamps else [])]


def rectangle_point(corner: Any, along: Any, across: Any, sample: Any) -> tuple[Any, Any]:
    """A point of a rectangle that is even in its solid angle from the origin, mi.Vector3f, and that angle [sr]."""
    length, width = dr.norm(along), dr.norm(across)
    x, y = along / length, across / width
    z = dr.cross(x, y)
    height = dr.dot(corner, z)
    z = dr.select(height > 0, -z, z)
    z0 = -dr.maximum(dr.abs(height), 1e-6)
    x0, y0 = dr.dot(corner, x), dr.dot(corner, y)
    x1, y1 = x0 + length, y0 + width
    corners = [mi.Vector3f(a, b, z0) for a, b in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    sides = [dr.normalize(dr.cross(corners[k], corners[(k + 1) % 4])) for k in range(4)]
    angles = [dr.safe_acos(-dr.dot(sides[k], sides[(k + 1) % 4])) for k in range(4)]
    rest = dr.two_pi - angles[2] - angles[3]
    solid = dr.maximum(angles[0] + angles[1] - rest, 0)
    b0, b1 = sides[0].z, sides[2].z
    turned = dr.fma(sample.x, solid, rest)
    ratio = (dr.cos(turned) * b0 - b1) / dr.sin(turned)
    cosine = dr.clip(dr.mulsign(dr.rsqrt(dr.square(ratio) + dr.square(b0)), ratio), -1, 1)
    px = dr.clip(-cosine * z0 / dr.maximum(dr.safe_sqrt(1 - dr.square(cosine)), 1e-7), x0, x1)
    off = dr.sqrt(dr.square(px) + dr.square(z0))
    low, high = (at * dr.rsqrt(dr.square(off) + dr.square(at)) for at in (y0, y1))
    part = dr.fma(sample.y, high - low, low)
    py = dr.clip(part * off / dr.maximum(dr.safe_sqrt(1 - dr.square(part)), 1e-7), y0, y1)
    return px * x + py * y + z0 * z, solid
