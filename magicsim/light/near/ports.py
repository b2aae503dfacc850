"""Ports of the contact face: patches and bins of directions, each of which counts as evenly bright.

Bins have equal projected solid angles, so what a port brings to a face is its radiance times one factor.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.light.backend import columns, dr, mi
from magicsim.light.transport.streams import generators

BELOW_MM = 1e-4
"""How far below the face rays start [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ports:
    """Patches of a face around the origin, times rings and sectors of directions into it."""

    footprint_mm: tuple[float, float]
    counts: tuple[int, int]
    """Patches along x and y."""
    rings: int
    sectors: int

    @classmethod
    def of(cls, footprint_mm: tuple[float, float], patch_mm: float, rings: int, sectors: int) -> Self:
        """Patches about as large as asked [mm]."""
        x, y = (max(1, round(side / patch_mm)) for side in footprint_mm)
        return cls(footprint_mm=footprint_mm, counts=(x, y), rings=rings, sectors=sectors)

    @property
    def bins(self) -> int:
        """Bins of directions."""
        return self.rings * self.sectors

    @property
    def count(self) -> int:
        """Number of ports, a patch's bins one after the other, patches x fastest."""
        return self.counts[0] * self.counts[1] * self.bins

    @property
    def flux_mm2(self) -> float:
        """Flux through a port of unit radiance [mm2]."""
        width, height = self.footprint_mm
        return np.pi * width * height / self.count

    def lines(self, each: int, *, seed: int) -> tuple[Array, Array]:
        """Lines spread evenly over every port: where they meet the face, and unit directions into the block.

        Args:
            each: Lines of a port.
            seed: Shifts each port's pattern.

        Returns:
            Two arrays of shape (ports * each, 3), a port's lines one after the other [mm].
        """
        steps = np.arange(each)[:, None] * (np.array(generators(4)) / 2.0**32)
        shifts = np.random.default_rng(seed).random((self.count, 1, 4))
        u, v, height, turn = np.moveaxis((steps + shifts) % 1, 2, 0)
        patch, way = np.divmod(np.arange(self.count)[:, None], self.bins)
        sine2, angle = (
            (way // self.sectors + height) / self.rings,
            2 * np.pi * (way % self.sectors + turn) / self.sectors,
        )
        sides = (np.array(self.footprint_mm) / self.counts).tolist()
        x = (patch % self.counts[0] + u) * sides[0] - self.footprint_mm[0] / 2
        y = (patch // self.counts[0] + v) * sides[1] - self.footprint_mm[1] / 2
        sine = np.sqrt(sine2)
        places = np.stack([x, y, np.full_like(x, -BELOW_MM)], 2)
        ways = np.stack([sine * np.cos(angle), sine * np.sin(angle), np.sqrt(1 - sine2)], 2)
        return places.reshape(-1, 3), ways.reshape(-1, 3)

    def owners(self, each: int) -> Index:
        """The port of each of its lines."""
        return np.repeat(np.arange(self.count), each)

    def met(self, ray: Any) -> tuple[Any, Any]:
        """Number of the port that each ray from below runs into, mi.UInt32, and whether there is one, mi.Bool."""
        place = ray(-ray.o.z / ray.d.z)
        across = [place[axis] / self.footprint_mm[axis] + 0.5 for axis in range(2)]
        found = (ray.d.z > 0) & (ray.o.z <= 0)
        for share in across:
            found &= (share >= 0) & (share < 1)
        places = [dr.clip(share, 0, 1) * count for share, count in zip(across, self.counts, strict=True)]
        x, y = (_below(place, count) for place, count in zip(places, self.counts, strict=True))
        ring = _below((1 - dr.square(ray.d.z)) * self.rings, self.rings)
        turn = dr.atan2(ray.d.y, ray.d.x) / dr.two_pi
        sector = _below((turn - dr.floor(turn)) * self.sectors, self.sectors)
        return ((x + self.counts[0] * y) * self.rings + ring) * self.sectors + sector, found


def rays_along(origins_mm: Array, ways: Array) -> Any:
    """Rays from places along unit directions, both of shape (rays, 3), mi.Ray3f."""
    return mi.Ray3f(mi.Point3f(*columns(origins_mm)), mi.Vector3f(*columns(ways)))


def _below(place: Any, count: int) -> Any:
    """Whole part of a place, below a count."""
    return dr.minimum(mi.UInt32(place), count - 1)
