"""Particles that the room sends: directions by how bright it is there, places on a disk that the scene fits behind.

Directions are drawn from cells of equal solid angle in proportion to the room's brightness, a share `EVEN` of them
alike in all, so that nothing between two cells gets too much weight. The particles of Mitsuba's own `envmap` (3.9.1)
did not give the means of its path tracer.
"""

from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from magicsim.light.aligned import aligned
from magicsim.light.backend import dr, mi

Array = npt.NDArray[np.float64]
RINGS, SECTORS = 64, 128
"""Cells of equal solid angle: heights of a unit sphere, and turns around the sensor's axis."""
BEYOND = 2.0
"""How far an object counts as lit, in radii of the scene's sphere."""
EVEN = 0.2
"""Share of the particles that are spread evenly."""


class Room(NamedTuple):
    """What the room shines on."""

    centre: Any
    """Centre of a sphere around it [mm]."""
    radius_mm: float
    away_mm: float
    """Distance from there at which nothing is in the way any more."""

    @classmethod
    def around(cls, box: Any, beyond: Any | None) -> Self:
        """Around a scene.

        Args:
            box: Of the scene.
            beyond: Of what stands outside, or None; what of it is further than `BEYOND` says only hides the room.
        """
        sphere = box.bounding_sphere()
        away = float(sphere.radius)
        if beyond is not None and beyond.valid():
            far = beyond.bounding_sphere()
            away = max(away, float(dr.norm(far.center - sphere.center)) + float(far.radius))
            near, reach = mi.ScalarBoundingBox3f(beyond), BEYOND * float(sphere.radius)
            near.clip(mi.ScalarBoundingBox3f(sphere.center - reach, sphere.center + reach))
            if near.valid():
                whole = mi.ScalarBoundingBox3f(box)
                whole.expand(near)
                sphere = whole.bounding_sphere()
        return cls(sphere.center, float(sphere.radius), max(away, float(sphere.radius)))


def room_particles(environment: Any, room: Room, *, u: list[Any]) -> tuple[Any, Any]:
    """First rays of particles, and their weights.

    Args:
        environment: The emitter.
        room: What it shines on.
        u: Four numbers in [0, 1) for each, mi.Float.
    """
    shares = mi.Float(aligned(_shares(environment), np.float32))
    cell, ring_part = mi.DiscreteDistribution(shares).sample_reuse(u[0])
    height = 2 * (mi.Float(cell // SECTORS) + ring_part) / RINGS - 1
    turn = dr.two_pi * (mi.Float(cell % SECTORS) + u[1]) / SECTORS
    sine = dr.safe_sqrt(1 - dr.square(height))
    way = mi.Vector3f(-sine * dr.cos(turn), -sine * dr.sin(turn), -height)
    chance = dr.gather(mi.Float, shares, cell) * (RINGS * SECTORS / (4 * dr.pi))
    offset = mi.Frame3f(way).to_world(
        mi.Vector3f(*mi.warp.square_to_uniform_disk_concentric(mi.Point2f(u[2], u[3])), 0)
    )
    radius, away = (dr.opaque(mi.Float, each) for each in (room.radius_mm, room.away_mm))
    ray = mi.Ray3f(mi.Point3f(room.centre) + radius * offset - away * way, way)
    return ray, _radiance(environment, way) * (dr.pi * dr.square(radius)) / chance


def _shares(environment: Any) -> Array:
    """Shares of the particles for each cell, ring after ring from below, shape (RINGS * SECTORS,)."""
    ring, sector = np.divmod(np.arange(RINGS * SECTORS), SECTORS)
    height, turn = 2 * (ring + 0.5) / RINGS - 1, 2 * np.pi * (sector + 0.5) / SECTORS
    sine = np.sqrt(1 - height**2)
    towards = np.stack([sine * np.cos(turn), sine * np.sin(turn), height])
    bright = np.broadcast_to(
        np.array(_radiance(environment, -mi.Vector3f(*(aligned(each, np.float32) for each in towards)))).sum(0),
        height.shape,
    )
    even = np.full(len(height), 1 / len(height))
    return np.asarray(EVEN * even + (1 - EVEN) * bright / bright.sum() if bright.sum() > 0 else even)


def _radiance(environment: Any, way: Any) -> Any:
    """Radiance of what arrives along ways, mi.Color3f."""
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(way))
    si.wi = way
    return mi.Color3f(environment.eval(si))
