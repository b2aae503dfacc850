"""Light on an opaque coat, and in a body that scatters under it: integrated, not found by chance.

What the camera sees of a coat is smooth, and paths find its lamps rarely. So light is known at knots, about a
millimetre apart on the coat, and in layers between it and the lens where the body scatters: for each, what comes from
the lamps on ways that need no search (`straight_light`), and what else is seen in a thousand fixed directions, by rays
that end where they meet the coat. Those take the light of the round before; a few rounds are all orders of reflection.
At the corners of each facet the straight light is then integrated over the facet's own hemisphere, with shadows as they
are at its vertices; the rest is taken from the knots around, and all of it is linear between the corners.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import make_interp_spline
from scipy.ndimage import correlate1d
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Index
from magicsim.light.backend import aligned, columns, dr, floats, in_rows, mi
from magicsim.light.transport.path_starts import ObjectStarts
from magicsim.light.world.coated_face import CoatedFace, CoatLight, outward_bins
from magicsim.light.world.coating import Coating
from magicsim.light.world.straight_light import Box, Lamps, Strips

KNOT_MM, WIDE_KNOT_MM = 1.0, 2.0
"""Distance of the knots that lamps are looked at from, and of those for all else, which comes from farther [mm]."""
RIM_MM = 0.5
"""How far knots stay from the rim, beside which the strips are [mm]."""
LIFT_MM = 0.01
"""How far within the body knots and vertices look around from [mm]."""
DIRECTIONS, FEWER = 16384, 2048
"""Directions that are looked in from a knot in the last round, and in those before it."""
CLOUDY_PART = 16
"""Directions where the body scatters are fewer by this factor: there are knots in it too, and nothing has an edge."""
KEPT = 1024
"""Directions that are kept of them, each with the light of those around it."""
ROUNDS = 4
"""A coat of reflectance 0.6 sends back a third of what it sends out; what is left after so many is below 0.2 %."""
FINE = (8, 8)
"""Points along and across a strip that are looked at from a knot; in each direction, two of them are taken as one."""
SHADOW = (6, 6)
"""Points of a strip that are looked at from a vertex, which tells shadows alone."""
NEIGHBOURS = (-1 / 16, 1 / 4, 5 / 8, 1 / 4, -1 / 16)
"""Shares of neighbouring knots in what is seen from one: chance is halved, and what bends stays."""
LAYERS = 5
"""Layers of knots in a body that scatters."""
SHADOW_STEPS = 2
"""How often shadows at vertices are averaged with their neighbours'."""


@dataclass(slots=True, kw_only=True)
class Seen:
    """Radiance times solid angle in as many directions from each place; on the renderer's side."""

    directions: Any
    light: Any
    each: int
    """Directions of a place."""

    @property
    def fluence(self) -> Array:
        """Fluence of each place, shape (places, 3)."""
        return np.asarray(in_rows(self.light).reshape(-1, self.each, 3).sum(1))


def directions(count: int) -> Array:
    """Directions even over the sphere, on Fibonacci's spiral, shape (count, 3)."""
    place = np.arange(count) + 0.5
    z, angle = 1 - 2 * place / count, np.pi * (1 + np.sqrt(5)) * place
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])


@cache
def _thinned(count: int) -> tuple[Array, sp.csr_matrix]:
    """Directions that are kept of so many, and which of these each stands for, shape (kept, count)."""
    if count <= KEPT:
        return directions(count), sp.identity(count, format="csr")
    fine, kept = directions(count), directions(KEPT)
    nearest = np.asarray(cKDTree(kept).query(fine)[1], np.int64)
    rows: Any = (np.ones(count), (nearest, np.arange(count)))
    taken: Any = sp.csr_matrix(rows, shape=(KEPT, count))
    mean = taken @ fine
    return mean / np.linalg.norm(mean, axis=1, keepdims=True), taken


@dataclass(slots=True, kw_only=True)
class Knots:
    """A grid over the undeformed face."""

    low: Array
    step: Array
    counts: tuple[int, int]
    vertex: Index
    """The vertex of the face next to each knot, x fastest."""

    @classmethod
    def over(cls, face: CoatedFace, step_mm: float) -> "Knots":
        """Knots so far apart."""
        places = face.rest_mm[face.vertices]
        low, high = places.min(0) + RIM_MM, places.max(0) - RIM_MM
        counts = np.maximum(2, np.round((high - low) / step_mm).astype(int) + 1)
        axes = [np.linspace(low[k], high[k], counts[k]) for k in range(2)]
        grid = np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
        nearest = np.asarray(cKDTree(places).query(grid)[1], np.int64)
        return cls(low=low, step=(high - low) / (counts - 1), counts=(int(counts[0]), int(counts[1])), vertex=nearest)

    def around(self, places: Array) -> tuple[Array, Array]:
        """Knots around places and their shares, bilinear, both of shape (places, 4)."""
        at = np.clip((places - self.low) / self.step, 0, np.array(self.counts) - 1 - 1e-6)
        first = at.astype(int)
        part = at - first
        knots = [first[:, 0] + dx + self.counts[0] * (first[:, 1] + dy) for dy in (0, 1) for dx in (0, 1)]
        shares = [np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1]) for dy in (0, 1) for dx in (0, 1)]
        return np.stack(knots, 1), np.stack(shares, 1)


@dr.syntax  # type: ignore[untyped-decorator]
def _sent_on(coating: Coating, seen: Seen, normal: Any, view: Any, knots: list[Any], shares: list[Any]) -> Any:
    """What a ground of reflectance 1 and facets send on of what is seen, two of mi.Color3f."""
    number = mi.UInt32(0)
    each = dr.opaque(mi.UInt32, seen.each)
    ground, mirrored = mi.Color3f(0), mi.Color3f(0)
    while number < each:
        for knot, part in zip(knots, shares, strict=True):
            place = knot * each + number
            direction = dr.gather(mi.Vector3f, seen.directions, place)
            light = dr.gather(mi.Color3f, seen.light, place) * part
            flat, bright = coating.shares(direction, view, normal)
            ground += light * flat
            mirrored += light * bright
        number += 1
    return ground, mirrored


@dr.syntax  # type: ignore[untyped-decorator]
def _integrated(
    coating: Coating, box: Box, lights: Strips | Lamps, place: Any, normal: Any, view: Any, row: Any, nodes: list[Any]
) -> Any:
    """What a ground of reflectance 1 and facets send on of one row of lights, nothing standing in its way."""
    number, count = mi.UInt32(0), dr.opaque(mi.UInt32, dr.width(nodes[0]))
    ground, mirrored = mi.Color3f(0), mi.Color3f(0)
    while number < count:
        sample = mi.Point2f(dr.gather(mi.Float, nodes[0], number), dr.gather(mi.Float, nodes[1], number))
        arriving = lights.arriving(row, place, sample, box)
        light = arriving.light * dr.gather(mi.Float, nodes[2], number)
        flat, bright = coating.shares(arriving.direction, view, normal)
        ground += light * flat
        mirrored += light * bright
        number += 1
    return ground, mirrored


@dataclass(slots=True, kw_only=True)
class CoatSolver:
    """What is to be known of a state of a sensor to find its coat's light."""

    scene: Any
    coating: Coating
    face: CoatedFace
    box: Box
    pinhole_mm: Array
    trace: Callable[[ObjectStarts, CoatLight, Array | None], Any]
    """What rays from within the body meet, mi.Color3f, by their starts, the coat's light and the voxels' fluence."""
    voxels_mm: Array | None
    """Centres of the voxels of a body that scatters, shape (voxels, 3) [mm]; None where it is clear."""

    def solved(self) -> tuple[CoatLight, Array | None]:
        """Light of the coat, and the fluence of each voxel, shape (voxels, 3), None where all is clear."""
        face, is_cloudy = self.face, self.voxels_mm is not None
        places, normals, rest_mm = face.places_mm[face.vertices], face.vertex_normals(), face.rest_mm[face.vertices]
        views = self._views(places)
        fine, wide = Knots.over(face, KNOT_MM), Knots.over(face, WIDE_KNOT_MM)
        at_fine, at_wide = (places[each.vertex] + LIFT_MM * normals[each.vertex] for each in (fine, wide))
        on_fine = fine.around(rest_mm)
        # What lamps bring to the face, and to the layers.
        straight = self._at_corners(places, normals, views)
        beside = self._received(self._straight(at_fine, by_sides=True), normals, views, *on_fine)
        layers = self._layers(at_wide) if is_cloudy else at_wide[:0]
        points = np.concatenate([at_wide, layers])
        glow0 = self._straight(layers).fluence if is_cloudy else None
        own: tuple[Any, Array] = (np.arange(len(at_fine))[:, None], np.ones((len(at_fine), 1)))
        is_wide, facing = self.coating.is_wide, normals[fine.vertex]
        lobes0 = self._outward(self._straight(at_fine), facing, *own) if is_wide else None
        corners = [(known + more[face.local]) for known, more in zip(straight, beside, strict=True)]
        at_knots = ((rest_mm - fine.low) / fine.step)[face.local]
        lobes, glow = lobes0, glow0
        light = CoatLight.of(face.maps(np.concatenate([*corners, at_knots], -1)), lobes, fine.counts, shown=False)
        for number in range(ROUNDS):
            is_last = number == ROUNDS - 1
            count = (DIRECTIONS if is_last else FEWER) // (CLOUDY_PART if is_cloudy else 1)
            seen = self._looked(points, count, light, self._in_voxels(glow, wide, at_wide), wide.counts)
            between = _between(seen, wide, fine)
            added = self._received(between, normals, views, *on_fine)
            values = [known + more[face.local] for known, more in zip(corners, added, strict=True)]
            if lobes0 is not None and not is_last:
                lobes = lobes0 + self._outward(between, facing, *own)
            if glow0 is not None:
                glow = glow0 + seen.fluence[len(at_wide) :]
            maps = face.maps(np.concatenate([*values, at_knots], -1))
            light = CoatLight.of(maps, lobes, fine.counts, shown=is_last)
        return light, self._in_voxels(glow, wide, at_wide)

    def _layers(self, on_coat: Array) -> Array:
        top = float(np.array(self.box.constants.top_mm)[0])
        heights = [on_coat[:, 2] + part * (top - on_coat[:, 2]) for part in (np.arange(LAYERS) + 0.5) / LAYERS]
        return np.concatenate([np.column_stack([on_coat[:, :2], each]) for each in heights])

    def _in_voxels(self, glow: Array | None, knots: Knots, on_coat: Array) -> Array | None:
        """Fluence of the voxels from that at the knots of all layers, linear between them."""
        if glow is None or self.voxels_mm is None:
            return None
        around, shares = knots.around(self.voxels_mm[:, :2])
        low = (shares * on_coat[around, 2]).sum(1)
        top = float(np.array(self.box.constants.top_mm)[0])
        level = np.clip((self.voxels_mm[:, 2] - low) / (top - low) * LAYERS - 0.5, -0.5, LAYERS - 0.5)
        first = np.clip(np.floor(level).astype(int), 0, LAYERS - 2)
        part = (level - first)[:, None]
        levels = glow.reshape(LAYERS, -1, 3)
        values = [(shares[:, :, None] * levels[(first + up)[:, None], around]).sum(1) for up in (0, 1)]
        return np.asarray(np.maximum((1 - part) * values[0] + part * values[1], 0))

    def _views(self, places: Array) -> Any:
        """Directions to the camera, refracted at the lens face."""
        place = mi.Point3f(*columns(places))
        crossing, _ = self.box.crossing(place, mi.Point3f(*self.pinhole_mm.tolist()))
        return dr.normalize(mi.Vector3f(crossing - place))

    def _straight(self, points: Array, *, by_sides: bool = False) -> Seen:
        """Light of the lamps at places [mm], shadows and all; perhaps only by ways that turn at a side."""
        parts_d, parts_l = [], []
        for lights in self.coating.lights:
            fine = lights.nodes(*FINE) if isinstance(lights, Strips) else lights.nodes()
            for row in range(lights.rows):
                if by_sides and row in lights.straight:
                    continue
                count, nodes = len(points), len(fine)
                lane = dr.arange(mi.UInt32, count * nodes)
                place = dr.gather(mi.Point3f, mi.Point3f(*columns(points)), lane // nodes)
                sample = mi.Point2f(*[dr.gather(mi.Float, floats(fine[:, k]), lane % nodes) for k in (0, 1)])
                weight = dr.gather(mi.Float, floats(fine[:, 2]), lane % nodes)
                arriving = lights.arriving(mi.UInt32(row), place, sample, self.box)
                seen = dr.select(arriving.unblocked(self.scene, mi.Bool(True)), arriving.light * weight, 0)
                light = in_rows(seen, np.float32).reshape(count, nodes, 3)
                if not light.any():
                    continue
                way = in_rows(arriving.direction, np.float32).reshape(count, nodes, 3)
                if isinstance(lights, Strips):
                    light, way = _merged(light, way)
                parts_d.append(way)
                parts_l.append(light)
        if not parts_l:
            parts_d, parts_l = [np.ones((len(points), 1, 3))], [np.zeros((len(points), 1, 3))]
        return _seen(np.concatenate(parts_d, 1), np.concatenate(parts_l, 1))

    def _looked(self, points: Array, count: int, light: CoatLight, glow: Array | None, counts: tuple[int, int]) -> Seen:
        """What is seen besides in fixed directions."""
        ways = directions(count)
        places, towards = np.repeat(points, count, 0), np.tile(ways, (len(points), 1))
        rays = mi.Ray3f(mi.Point3f(*columns(places)), mi.Vector3f(*columns(towards)))
        numbers = dr.arange(mi.UInt32, len(places))
        dr.eval(numbers, rays)
        starts = replace(ObjectStarts.of(numbers, rays, mi.Float(1), mi.Bool(True)), asked=1)
        seen = self.trace(starts, light, glow)
        found = in_rows(seen, np.float32).reshape(-1, counts[1], counts[0], count, 3) * (4 * np.pi / count)
        # What chance is left in it is not that of the neighbours, and what is seen hardly changes between them.
        found = correlate1d(correlate1d(found, NEIGHBOURS, 1, mode="nearest"), NEIGHBOURS, 2, mode="nearest")
        kept, taken = _thinned(count)
        if len(kept) < count:
            found = np.moveaxis(found.reshape(len(points), count, 3), 1, 0).reshape(count, -1)
            found = np.moveaxis((taken @ found).reshape(len(kept), len(points), 3), 0, 1)
        return _seen(np.broadcast_to(kept, (len(points), *kept.shape)), found.reshape(len(points), len(kept), 3))

    def _received(self, seen: Seen, normals: Array, views: Any, knots: Array, shares: Array) -> list[Array]:
        lists = (
            [mi.UInt32(aligned(each, np.uint32)) for each in knots.T],
            [floats(each) for each in shares.T],
        )
        ground, mirrored = _sent_on(self.coating, seen, mi.Vector3f(*columns(normals)), views, *lists)
        return [in_rows(each) for each in (ground, mirrored)]

    def _outward(self, seen: Seen, normals: Array, knots: Array, shares: Array) -> Array:
        """What facets at fine knots send out in some directions, shape (knots, directions, 3)."""
        outward, count = outward_bins(), len(normals)
        views = mi.Vector3f(*columns(np.tile(outward, (count, 1))))
        lists = [np.repeat(each, len(outward), 0) for each in (normals, knots, shares)]
        found = self._received(seen, lists[0], views, *lists[1:])
        return found[1].reshape(count, len(outward), 3)

    def _at_corners(self, places: Array, normals: Array, views: Any) -> list[Array]:
        """Straight light at the corners of all facets, two of shape (facets, 3, 3)."""
        face, totals = self.face, [np.zeros((len(self.face.local), 3, 3)) for _ in range(2)]
        corner = np.repeat(face.facet_normals(), 3, 0)
        index = face.local.ravel()
        place = mi.Point3f(*columns(places[index] + LIFT_MM * corner))
        view = dr.gather(mi.Vector3f, views, mi.UInt32(aligned(index, np.uint32)))
        for lights in self.coating.lights:
            nodes = [floats(each) for each in lights.nodes().T]
            for row in lights.straight:
                clear = self._clear(lights, row, places + LIFT_MM * normals, normals)
                found = _integrated(
                    self.coating, self.box, lights, place, mi.Vector3f(*columns(corner)), view,
                    dr.opaque(mi.UInt32, row), nodes,
                )  # fmt: skip
                for part, each in enumerate(found):
                    totals[part] += in_rows(each).reshape(-1, 3, 3) * clear[face.local][:, :, None]
        return totals

    def _clear(self, lights: Strips | Lamps, row: int, places: Array, normals: Array) -> Array:
        """Share of the light of one row that nothing keeps from vertices, shape (vertices,)."""
        shape = SHADOW if isinstance(lights, Strips) else (min(lights.count, SHADOW[0] * SHADOW[1]), 1)
        count, nodes = len(places), shape[0] * shape[1]
        lane = dr.arange(mi.UInt32, count * nodes)
        numbers = mi.PCG32(size=count * nodes)
        node = lane % nodes
        sample = mi.Point2f(
            (mi.Float(node // shape[1]) + numbers.next_float32()) / shape[0],
            (mi.Float(node % shape[1]) + numbers.next_float32()) / shape[1],
        )
        place, normal = (
            dr.gather(kind, kind(*columns(each)), lane // nodes)
            for kind, each in ((mi.Point3f, places), (mi.Vector3f, normals))
        )
        arriving = lights.arriving(mi.UInt32(row), place, sample, self.box)
        weight = dr.max(arriving.light) * dr.maximum(dr.dot(arriving.direction, normal), 0)
        seen = dr.select(arriving.unblocked(self.scene, weight > 0), weight, 0)
        both = [np.array(each, np.float64).reshape(count, nodes).sum(1) for each in (seen, weight)]
        smooth = self.face.averaged(np.stack(both, 1), SHADOW_STEPS)
        return np.divide(smooth[:, 0], smooth[:, 1], out=np.ones(count), where=smooth[:, 1] > 0)


def _between(seen: Seen, wide: Knots, fine: Knots) -> Seen:
    """What is seen from fine knots, by cubic splines between wide ones."""
    (nx, ny), each = wide.counts, seen.each
    light = in_rows(seen.light, np.float32).reshape(-1, each * 3)[: nx * ny].reshape(ny, nx, -1)
    rows, along = (_spline(wide, fine, axis) for axis in (1, 0))
    spread = np.einsum("xX,yXc->yxc", along, np.tensordot(rows, light, 1), optimize=True)
    ways = in_rows(seen.directions, np.float32)[:each].reshape(1, each, 3)
    count = fine.counts[0] * fine.counts[1]
    return _seen(np.broadcast_to(ways, (count, each, 3)), spread.reshape(count, each, 3))


def _spline(wide: Knots, fine: Knots, axis: int) -> Array:
    """Shares of wide knots in the values at fine ones along one axis, shape (fine, wide)."""
    places = [each.low[axis] + each.step[axis] * np.arange(each.counts[axis]) for each in (wide, fine)]
    kind = min(3, len(places[0]) - 1)
    return np.asarray(make_interp_spline(places[0], np.eye(len(places[0])), k=kind)(places[1]))


def _seen(ways: Array, light: Array) -> Seen:
    directions, seen = mi.Vector3f(*columns(ways.reshape(-1, 3))), mi.Color3f(*columns(light.reshape(-1, 3)))
    return Seen(directions=directions, light=seen, each=light.shape[1])


def _merged(light: Array, ways: Array) -> tuple[Array, Array]:
    """Pairs of points along and across a strip taken as one, in the mean direction of their light."""
    places, nodes = light.shape[:2]
    shape = (places, FINE[0] // 2, 2, FINE[1] // 2, 2, 3)
    total = light.reshape(shape).sum((2, 4)).reshape(places, nodes // 4, 3)
    weight = light.sum(-1, keepdims=True) + 1e-12
    mean = (weight * ways).reshape(shape).sum((2, 4)).reshape(places, nodes // 4, 3)
    return total, mean / np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1e-30)
