"""Light that comes to a place within the body straight from a lamp, by one reflection at the lens face, or through it.

A strip within the body is a rectangle. Points on it that are even in the solid angle that it fills (Ureña, Fajardo and
King 2013, *An Area-Preserving Parametrization for Spherical Rectangles*) leave an integrand that is smooth and bounded,
however near the strip is. What the flat lens face mirrors of it is what the place's mirror image sees. To a lamp above
the lens face a ray is refracted: where it crosses the face follows from Snell's law in the plane of both points.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.light.backend import aligned, columns, dr, mi
from magicsim.light.world.lamp_shapes import LobeLight
from magicsim.light.world.medium import Constants, scattering_stretch
from magicsim.light.world.shapes import lights, mesh_of, shape_named

SHORT_OF_LIGHT = 1 - 1e-4
"""Part of the way to a light on which nothing may stand."""
BELOW_PLATE_MM = 1e-4
"""How near to the lens face a hit counts as on it, and a shadow ray goes on from it [mm]."""
NEWTON_STEPS = 6
"""To where a ray crosses the lens face: exact to single precision from the paraxial guess."""
ALONG, ACROSS = 8, 4
"""Gauss points along and across a strip."""
LEAST = 1e-9


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
            tested = mi.Ray3f(ray)
            tested.maxt = length * SHORT_OF_LIGHT
            clear &= ~scene.ray_test(tested, clear)
        return clear


@dataclass(slots=True, kw_only=True)
class Plate:
    """The flat lens face over the body, and what is on the way to it; on the renderer's side."""

    height_mm: Any
    half_mm: tuple[Any, Any]
    """Half of its size along x and y [mm]."""
    constants: Constants

    def kept(self, ray: Any, length: Any) -> Any:
        """Part of light that comes along a ray within the body."""
        body = self.constants.body
        _, stretch = scattering_stretch(ray, length, self.constants.top_mm)
        return dr.exp(-body.sigma_t * stretch - body.sigma_a * (length - stretch))

    def crossing(self, place: Any, point: Any) -> tuple[Any, Any]:
        """Where light from a point above the face to a place below it crosses it, and distances along the face.

        Returns:
            The crossing, mi.Point3f; its distance along the face from the place, mi.Float [mm].
        """
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
class Strip:
    """A matt rectangle within the body."""

    corner: Any
    along: Any
    across: Any
    normal: Any
    radiance: Any
    ways = ("straight", "mirrored")

    @classmethod
    def of(cls, shape: Any, radiance: Any) -> "Strip":
        """The rectangle of the scene."""
        matrix = np.array(mi.traverse(shape)["to_world"].matrix, float).reshape(4, 4)
        u, v, middle = matrix[:3, 0], matrix[:3, 1], matrix[:3, 3]
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        parts = [
            mi.Vector3f(*(dr.opaque(mi.Float, float(at)) for at in each))
            for each in (middle - u - v, 2 * u, 2 * v, normal)
        ]
        return cls(corner=parts[0], along=parts[1], across=parts[2], normal=parts[3], radiance=radiance)

    def nodes(self) -> Array:
        """Points of a quadrature over it and their weights, shape (nodes, 3)."""
        (u, a), (v, b) = (np.polynomial.legendre.leggauss(count) for count in (ALONG, ACROSS))
        places = np.stack(np.meshgrid((u + 1) / 2, (v + 1) / 2, indexing="ij"), -1).reshape(-1, 2)
        return np.column_stack([places, np.outer(a, b).ravel() / 4])

    def arriving(self, way: str, place: Any, sample: Any, plate: Plate) -> Arriving:
        """From the point of a sample, an even density in the solid angle.

        Args:
            way: One of `ways`.
            place: Within the body, mi.Point3f.
            sample: mi.Point2f in the unit square.
            plate: The lens face.
        """
        seen_from = mi.Point3f(place)
        if way == "mirrored":
            seen_from.z = 2 * plate.height_mm - place.z
        point, angle = rectangle_point(self.corner - mi.Vector3f(seen_from), self.along, self.across, sample)
        distance = dr.norm(point)
        direction = point / distance
        light = self.radiance * dr.select(dr.dot(direction, self.normal) < 0, angle, 0)
        if way == "straight":
            ray = mi.Ray3f(place, direction)
            return Arriving(direction=direction, light=light * plate.kept(ray, distance), legs=[(ray, distance)])
        away = mi.Vector3f(direction.x, direction.y, -direction.z)
        first = (seen_from.z - plate.height_mm) / dr.maximum(away.z, LEAST)
        rising = mi.Ray3f(place, away)
        falling = mi.Ray3f(seen_from + direction * (first + BELOW_PLATE_MM), direction)
        second = distance - first - BELOW_PLATE_MM
        there = (away.z > 0) & (second > 0)
        there &= (dr.abs(falling.o.x) < plate.half_mm[0]) & (dr.abs(falling.o.y) < plate.half_mm[1])
        share = mi.fresnel(-dr.abs(direction.z), plate.constants.body_ior)[0]
        share *= plate.kept(rising, first) * plate.kept(falling, second)
        return Arriving(
            direction=away, light=light * dr.select(there, share, 0), legs=[(rising, first), (falling, second)]
        )


@dataclass(slots=True, kw_only=True)
class Lamp:
    """A lamp above the lens face: triangles, each of which counts as a point where it is not sampled."""

    points: Any
    """Middle of each triangle, mi.Point3f [mm]."""
    corners: list[Any]
    """The corners of each, mi.Point3f [mm]."""
    normals: Any
    areas: Any
    """Of each [mm2]."""
    exponent: float
    """Of the cosine that the intensity falls with."""
    radiance: Any
    ways = ("refracted",)

    @classmethod
    def of(cls, shape: Any, radiance: Any, exponent: float) -> "Lamp":
        """The lamp of the scene."""
        mesh = mesh_of(shape)
        corners = mesh.vertices[mesh.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        double = np.linalg.norm(cross, axis=1)
        return cls(
            points=mi.Point3f(*columns(corners.mean(1))), corners=[mi.Point3f(*columns(each)) for each in corners.swapaxes(0, 1)],
            normals=mi.Vector3f(*columns(cross / double[:, None])), areas=mi.Float(aligned(double / 2, np.float32)),
            exponent=exponent, radiance=radiance,
        )  # fmt: skip

    def nodes(self) -> Array:
        """One for each triangle: its number and 1, shape (nodes, 3)."""
        count = dr.width(self.areas)
        return np.column_stack([(np.arange(count) + 0.5) / count, np.full(count, -1.0), np.full(count, 1 / count)])

    def arriving(self, way: str, place: Any, sample: Any, plate: Plate) -> Arriving:
        """From a point of the triangle that the sample's first part tells, the density even over the triangles.

        Args:
            way: One of `ways`.
            place: Within the body, mi.Point3f.
            sample: mi.Point2f in the unit square; where the second is negative, the middle of the triangle.
            plate: The lens face.
        """
        del way
        count = dr.width(self.areas)
        triangle = dr.minimum(mi.UInt32(sample.x * count), count - 1)
        middle = dr.gather(mi.Point3f, self.points, triangle)
        a, b, c = (dr.gather(mi.Point3f, each, triangle) for each in self.corners)
        # Uniform over a triangle: the square folded along its diagonal.
        right, up = sample.x * count - mi.Float(triangle), dr.maximum(sample.y, 0)
        folded = right + up > 1
        right, up = dr.select(folded, 1 - right, right), dr.select(folded, 1 - up, up)
        point = dr.select(sample.y < 0, middle, a + right * (b - a) + up * (c - a))
        normal, area = dr.gather(mi.Vector3f, self.normals, triangle), dr.gather(mi.Float, self.areas, triangle)
        crossing, at = plate.crossing(place, point)
        inner, outer = crossing - place, point - crossing
        first, second = dr.norm(inner), dr.norm(outer)
        inside, outside = inner / dr.maximum(first, LEAST), outer / dr.maximum(second, LEAST)
        reach = dr.norm(mi.Vector2f(point.x - place.x, point.y - place.y))
        ior = plate.constants.body_ior
        below, above = plate.height_mm - place.z, point.z - plate.height_mm
        # Solid angle within the body for each area of the plane of the point.
        spread = below / dr.square(inside.z) + above / dr.square(outside.z) * ior * inside.z / outside.z
        turn = dr.select(reach > 1e-3, at / dr.maximum(reach, LEAST), below / (below + ior * above))
        angle = turn / (first * spread)
        facing = -dr.dot(outside, normal)
        flat = area * count * dr.maximum(facing, 0) / outside.z
        there = (above > 0) & (facing > 0)
        there &= (dr.abs(crossing.x) < plate.half_mm[0]) & (dr.abs(crossing.y) < plate.half_mm[1])
        ray = mi.Ray3f(place, inside)
        share = (1 - mi.fresnel(-inside.z, ior)[0]) * dr.square(ior) * plate.kept(ray, first)
        share *= angle * flat * dr.power(dr.maximum(facing, 0), self.exponent - 1)
        beyond = mi.Ray3f(crossing + outside * BELOW_PLATE_MM, outside)
        return Arriving(
            direction=inside, light=self.radiance * dr.select(there, share, 0),
            legs=[(ray, first), (beyond, second - BELOW_PLATE_MM)],
        )  # fmt: skip


def straight_lights(scene: Any, inside: tuple[str, ...], above_mm: float) -> list[Strip | Lamp]:
    """Lights that are asked for by themselves: the strips within the body, and what stands above the lens face.

    Args:
        scene: The loaded scene.
        inside: Names of the strips within the body.
        above_mm: Height of the lens face [mm].
    """
    found: list[Strip | Lamp] = []
    for name in lights(scene):
        shape = shape_named(scene, name)
        if shape is None:
            continue
        emitter = shape.emitter()
        value = np.broadcast_to(np.array(mi.traverse(emitter)["radiance.value"], float).ravel(), 3).tolist()
        radiance = mi.Color3f(*(dr.opaque(mi.Float, channel) for channel in value))
        if name in inside:
            found.append(Strip.of(shape, radiance))
        elif shape.is_mesh() and shape.bbox().max.z > above_mm:
            exponent = emitter.exponent if isinstance(emitter, LobeLight) else 1.0
            found.append(Lamp.of(shape, radiance, float(exponent)))
    return found


def rectangle_point(corner: Any, along: Any, across: Any, sample: Any) -> tuple[Any, Any]:
    """A point of a rectangle that is even in the solid angle as it is seen from the origin, and that angle.

    Args:
        corner: Of the rectangle, from where it is seen, mi.Vector3f.
        along: One edge of it.
        across: The other one.
        sample: mi.Point2f in the unit square.

    Returns:
        The point, mi.Vector3f, and the solid angle, mi.Float [sr].
    """
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
