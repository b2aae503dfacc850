"""Light of the flashlight in the untouched block, with nothing between them, and what an object keeps away of it.

Particles bring the light once for each place of the flashlight. What an object hides is summed up along lines from the
contact face to the flashlight (area sampling), port by port of the light that comes in.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.arrays import Array, Mask, Numbers
from magicsim.light.backend import dr, mi
from magicsim.light.frame.frame_light import kept_out
from magicsim.light.near.near_object import radiance_of
from magicsim.light.near.ports import BELOW_MM, Ports, rays_along
from magicsim.light.records.recorded_paths import WEIGHT, RecordedPaths
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.light_pass import sum_tracks
from magicsim.light.transport.light_starts import FIXED_POINT, ROOM_PART
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.light.world.room_light import PassingLight, missed
from magicsim.scenes.rig import Flashlight

LINES = 128
"""Lines from each patch of the face to the flashlight."""


class LampDisk(NamedTuple):
    """The flashlight as it is met from above."""

    centre: Any
    """mi.Point3f [mm]."""
    radius: Any
    radiance: Any
    """mi.Color3f."""

    @classmethod
    def of(cls, lamp: Flashlight, light_x_mm: float) -> Self:
        """Shifted along x [mm]; its numbers are no part of kernels."""
        centre = (lamp.x_mm + light_x_mm, lamp.y_mm, -lamp.distance_mm)
        opaque = [[dr.opaque(mi.Float, value) for value in each] for each in (centre, lamp.radiance)]
        return cls(mi.Point3f(*opaque[0]), dr.opaque(mi.Float, lamp.radius_mm), mi.Color3f(*opaque[1]))

    def met(self, si: Any) -> Any:
        """Whether rays from `si.p` along `-si.wi` run into it, mi.Bool."""
        far = (self.centre.z - si.p.z) / -si.wi.z
        place = si.p - far * si.wi - self.centre
        return (si.wi.z > 0) & (far > 0) & (dr.square(place.x) + dr.square(place.y) < dr.square(self.radius))


@dataclass(frozen=True, slots=True, kw_only=True)
class LampLight:
    """What a flashlight in one place adds to one untouched sensor."""

    disk: LampDisk
    brought: Array
    """What it brings to cells and voxels, shape (cells + voxels, 3)."""
    change: Array
    """That less what it hides of the room's light there, of the same shape."""
    glow: Array
    """Radiance of each pixel from there, shape (pixels, 3)."""
    lines: Any
    """From the lamp to the face, mi.Ray3f."""
    sums: sp.csr_matrix
    """Radiance that each line from the lamp stands for in its port, shape (ports, lines)."""
    ported: npt.NDArray[np.float32]
    """What all of them together bring to cells and voxels by way of the ports, shape (cells + voxels,)."""
    rays: Any
    """Rays of the pixels that left the block and meet the lamp, mi.Ray3f."""
    weight: Array
    """Weight of each of them, shape (rays, 1)."""
    owner: Numbers
    """The pixel of each."""
    seen: Array
    """Radiance of the lamp less that of the room behind it, times the weight, shape (rays, 3)."""

    @classmethod
    def of(
        cls, world: LitWorld, paths: RecordedPaths, outside: Outside, into: Ports, ported: npt.NDArray[np.float32], *,
        lamp: Flashlight, light_x_mm: float, particles: int, seed: int,
    ) -> Self:  # fmt: skip
        """Traces it.

        Args:
            world: The scene with nothing before the block.
            paths: Of the pixels.
            outside: The lamp alone, in its place.
            into: Ports of light that comes in.
            ported: What each of them brings to cells and voxels, shape (cells + voxels, ports).
            lamp: Its size and place.
            light_x_mm: Shift of the lamp along x [mm].
            particles: That it sends, and a part of them the room.
            seed: Of these.
        """
        field = world.light_fields({FLASHLIGHT: particles}, seed=seed, outside=outside)[FLASHLIGHT]
        shade = _shade(world, outside, max(1, particles // ROOM_PART), seed)
        change = replace(field, fluence=field.fluence - shade.fluence, body=field.body - shade.body)
        disk, pixels = LampDisk.of(lamp, light_x_mm), np.arange(len(paths.direct), dtype=np.uint32)
        ends, around = replace(into, rings=1, sectors=1).lines(LINES, seed=0)  # these ways cover a disk evenly
        starts = np.array([lamp.x_mm + light_x_mm, lamp.y_mm, -lamp.distance_mm]) + lamp.radius_mm * around * [1, 1, 0]
        way = ends - starts
        far = np.linalg.norm(way, axis=1)
        way /= far[:, None]
        lines = rays_along(starts + BELOW_MM * way, way)
        lines.maxt = mi.Float(far - 2 * BELOW_MM)
        port, found = (np.array(each) for each in into.met(lines))
        found &= ~np.array(world.scene.ray_test(lines))
        share = (found * way[:, 2] ** 2 / far**2).astype(np.float32)
        sums = sp.csr_matrix((share, (np.where(found, port, 0), np.arange(len(port)))), (into.count, len(port)))
        table = np.array(paths.rays).reshape(-1, 8)
        chosen = np.flatnonzero(np.array(disk.met(missed(rays_along(table[:, :3], table[:, 3:WEIGHT])))))
        kept = table[chosen]
        rays, weight = rays_along(kept[:, :3], kept[:, 3:WEIGHT]), kept[:, WEIGHT : WEIGHT + 1]
        rays.maxt = mi.Float((kept[:, 2] + lamp.distance_mm) / -kept[:, 5])
        return cls(
            disk=disk, brought=np.concatenate([field.fluence, field.body]),
            change=np.concatenate([change.fluence, change.body]),
            glow=paths.glow(world.elements(change), pixels), lines=lines, sums=sums, ported=ported @ sums.sum(1).A1,
            rays=rays, weight=weight, owner=paths.owner[chosen],
            seen=weight * (np.array(lamp.radiance) - radiance_of(world.inventory.environment, rays)),
        )  # fmt: skip

    def is_behind(self, lines: Any) -> Mask:
        """Which lines that leave the face run into it, shape (lines,)."""
        return np.array(self.disk.met(missed(lines)))

    def image(self, passing: PassingLight | None, scene: Any = None) -> Array:
        """Radiance that it adds to each pixel, less what it hides of the room, shape (pixels, 3).

        Args:
            passing: What passes behind it.
            scene: What stands before it, if anything does.
        """
        seen = self.seen - self.weight * radiance_of(passing, self.rays)
        if scene is not None:
            seen *= ~np.array(scene.ray_test(self.rays))[:, None]
        count = len(self.glow)
        return self.glow + np.stack([np.bincount(self.owner, seen[:, channel], count) for channel in range(3)], 1)

    def hidden(self, scene: Any, ported: npt.NDArray[np.float32]) -> Array:
        """Light in cells and voxels that what stands in a scene keeps away, shape (cells + voxels, 3).

        Bins of directions are much wider than the lamp, so the ports tell the share of its light alone.

        Args:
            scene: The lines are followed in it.
            ported: What each port that comes in brings to cells and voxels, shape (cells + voxels, ports).
        """
        stopped = ported @ (self.sums @ np.array(scene.ray_test(self.lines), np.float32))
        share = np.divide(stopped, self.ported, out=np.zeros_like(stopped), where=self.ported > 0)
        return np.asarray(share[:, None] * self.brought)


def _shade(world: LitWorld, outside: Outside, particles: int, seed: int) -> LightField:
    """Light of the room in the untouched block that a lamp alone outside keeps away."""
    if ENVIRONMENT not in world.lights:
        return world.darkness()
    sent = world.sent(ENVIRONMENT, particles, seed=seed, outside=outside)
    tracks = [world.light_pass(hidden) for _, hidden in kept_out(world, outside, sent)]
    if not tracks:
        return world.darkness()
    return world.brought(sum_tracks(tracks), 1 / (FIXED_POINT * particles))
