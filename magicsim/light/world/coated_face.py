"""The coated face's triangles, and what they send out where that is known before any path meets them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array, Index
from magicsim.light.backend import columns, dr, floats, mi

UPWARDS, AROUND = 8, 16
"""Directions in which it is kept what facets send out: heights, and angles at each."""
COEFFICIENTS = 8
"""Values that are linear on a facet: ground and facets in three channels, and the place among the knots."""


@dataclass(frozen=True, kw_only=True)
class CoatedFace:
    """The face's own triangles in one state."""

    places_mm: Array
    """Vertices of the body, shape (vertices, 3) [mm]."""
    rest_mm: Array
    """Along x and y where they were undeformed, shape (vertices, 2) [mm]."""
    facets: Index
    """Corners of the face's triangles, shape (facets, 3)."""
    numbers: Index
    """Numbers of the face's triangles among those of the body, shape (facets,)."""
    triangles: int
    """Number of the body's triangles."""

    @cached_property
    def vertices(self) -> Index:
        """Vertices of the face."""
        return np.unique(self.facets)

    @cached_property
    def local(self) -> Index:
        """Corners of the facets as numbers of `vertices`, shape (facets, 3)."""
        return np.searchsorted(self.vertices, self.facets)

    def facet_normals(self) -> Array:
        """Into the body, shape (facets, 3)."""
        return -_unit(self._crosses())

    def vertex_normals(self) -> Array:
        """Mean of the facets around each vertex by their areas, shape (vertices of the face, 3)."""
        total = np.zeros((len(self.vertices), 3))
        np.add.at(total, self.local.ravel(), np.repeat(self._crosses(), 3, 0))
        return -_unit(total)

    def _crosses(self) -> Array:
        corners = self.places_mm[self.facets]
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def averaged(self, values: Array, steps: int) -> Array:
        """Values of the face's vertices, averaged with their neighbours' so often, of the same shape."""
        count = len(self.vertices)
        pairs = np.concatenate([self.local[:, [a, b]] for a in range(3) for b in range(3)])
        shares = sp.csr_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
        for _ in range(steps):
            values = shares @ values
            values = values / np.asarray(shares.sum(1))
        return values

    def maps(self, values: Array) -> Array:
        """Linear maps from places on the body's triangles to values, shape (triangles, values, 4); 0 off the face."""
        found = np.zeros((self.triangles, values.shape[-1], 4))
        found[self.numbers] = affine_maps(self.places_mm[self.facets], values)
        return found


def outward_bins() -> Array:
    """Middles of the directions in which light of facets is kept, shape (UPWARDS * AROUND, 3)."""
    z = (np.repeat(np.arange(UPWARDS), AROUND) + 0.5) / UPWARDS
    angle = 2 * np.pi * (np.tile(np.arange(AROUND), UPWARDS) + 0.5) / AROUND
    flat = np.sqrt(1 - z**2)
    return np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z])


@dataclass(slots=True, kw_only=True)
class CoatLight:
    """What an opaque coat sends out of all light, see `transport.coat_light`; on the renderer's side."""

    maps: Any
    """Linear maps of each triangle of the body, `COEFFICIENTS` times four floats."""
    lobes: Any
    """What facets send out at each knot in each direction, mi.Color3f; None where they have no part in it."""
    counts: tuple[Any, Any]
    """Knots along x and y."""
    shown: bool
    """Whether `maps` hold what facets send to the camera."""

    @classmethod
    def of(cls, maps: Array, lobes: Array | None, counts: tuple[int, int], *, shown: bool) -> Self:
        """Light from arrays of NumPy."""
        sent = mi.Color3f(*columns(lobes.reshape(-1, 3))) if lobes is not None else None
        sizes = tuple(dr.opaque(mi.UInt32, count) for count in counts)
        return cls(maps=floats(maps), lobes=sent, counts=sizes, shown=shown)

    def sent(self, si: Any, color: Any, straight: Any, active: Any) -> Any:
        """Radiance of the coat where paths meet it, mi.Color3f, some of which come straight from the camera."""
        row = COEFFICIENTS * si.prim_index
        values = [dr.gather(mi.Vector4f, self.maps, row + k, active) for k in range(COEFFICIENTS)]
        found = [dr.fma(m.x, si.p.x, dr.fma(m.y, si.p.y, dr.fma(m.z, si.p.z, m.w))) for m in values]
        ground, mirrored = mi.Color3f(*found[:3]) * color, mi.Color3f(0)
        if self.lobes is not None:
            mirrored = self._outwards(si, found[6:], active)
            mirrored = dr.select(straight & self.shown, mi.Color3f(*found[3:6]), mirrored)
        return dr.select(active, dr.maximum(ground + mirrored, 0), 0)

    def _outwards(self, si: Any, place: list[Any], active: Any) -> Any:
        """What facets of the nearest knot send where a path came from, linear between directions."""
        knot = [mi.UInt32(dr.clip(at + 0.5, 0, mi.Float(n) - 0.5)) for at, n in zip(place, self.counts, strict=True)]
        first = (knot[1] * self.counts[0] + knot[0]) * (UPWARDS * AROUND)
        away = si.to_world(si.wi)
        height = dr.clip(away.z * UPWARDS - 0.5, 0, UPWARDS - 1)
        turn = dr.atan2(away.y, away.x) * (AROUND / dr.two_pi) - 0.5
        turn = dr.select(turn < 0, turn + AROUND, turn)
        low, left = mi.UInt32(height), dr.minimum(mi.UInt32(turn), AROUND - 1)
        up, right = dr.minimum(low + 1, UPWARDS - 1), (left + 1) % AROUND
        u, v = height - mi.Float(low), turn - mi.Float(left)

        def at(level: Any, side: Any) -> Any:
            return dr.gather(mi.Color3f, self.lobes, first + level * AROUND + side, active)

        return dr.lerp(dr.lerp(at(low, left), at(low, right), v), dr.lerp(at(up, left), at(up, right), v), u)


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30))


def affine_maps(corners: Array, places: Array) -> Array:
    """Maps of triangles in space to a plane, constant along normals: coefficients of x, y, z, 1, (triangles, 2, 4)."""
    edges = (corners[:, 1:] - corners[:, :1]).swapaxes(1, 2)
    steps = (places[:, 1:] - places[:, :1]).swapaxes(1, 2)
    linear = steps @ np.linalg.pinv(edges)
    shift = places[:, 0] - np.einsum("tij,tj->ti", linear, corners[:, 0])
    return np.concatenate([linear, shift[..., None]], -1)
