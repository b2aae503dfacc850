"""Pictures of what is near the untouched sensor by compressed transport: no particle and no path through the grid.

Rendering is linear in light. What an object changes of the light that comes in through the face (its own in place of
the room's) is summed up over ports; a matrix says what that makes of the light in each cell, and a row for each pixel
what the pixel sees of it. A few of each pixel's recorded rays look at the object itself, and what it mirrors of them
meets ports again. Light that leaves the block reaches the object out of ports as well, and what the object sends back
changes those in turn.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.arrays import Array, Index, Numbers
from magicsim.kernels import kernel
from magicsim.light.backend import columns, dr, in_rows, mi
from magicsim.light.near.lamp_light import LampDisk, LampLight
from magicsim.light.near.near_object import NearObject, radiance_of
from magicsim.light.near.ports import Ports, rays_along
from magicsim.light.records.recorded_paths import MOMENTS, WEIGHT, RecordedPaths, record_paths
from magicsim.light.records.untouched import Untouched
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_starts import FIXED_POINT, LightStarts
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.path_record import PathRecord
from magicsim.light.transport.path_starts import ObjectStarts
from magicsim.light.transport.streams import ON_OBJECT, SEEDS_PER_RENDER
from magicsim.light.world.names import ENVIRONMENT
from magicsim.light.world.room_light import PassingLight

OUT = (1.0, 3, 8)
"""Ports of light that leaves: edge of a patch [mm], about the grid's pitch, rings and sectors of directions."""
INTO = (2.0, 2, 6)
"""Ports of light that comes in, which scatters over millimetres."""
OUT_PATHS, INTO_LINES, PARTICLES = 4, 4, 64
"""Paths of a port that leaves, lines and particles of one that comes in."""
SEEN_RAYS, MIRROR_RAYS, BACK_RAYS = 8, 16, 1
"""Rays of a pixel and of a port that look at the object, of all that were recorded; of a pixel at a glossy one."""
OBJECT_RAYS = 12_000
"""Rays from an object that look at the ports."""
TURNS = 2
"""How often light goes from the object into the block and back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NearTransport:
    """Compressed transport of one untouched sensor: light through its ports, which all episodes of it share."""

    world: LitWorld
    """The scene with nothing before the block."""
    rest: Untouched
    brought: npt.NDArray[np.float32]
    """What each port that comes in brings to cells and voxels, by unit radiance, shape (cells + voxels, ports)."""
    into: Ports
    """Ports of light that comes in."""
    ports: Ports
    """Ports of light that leaves."""
    room: Array
    """Radiance of each of these by the room's light in the block when nothing is near, shape (ports, 3)."""
    strips: Array
    """That by the strips' light, shape (ports, 3)."""
    lines: Any
    """Lines of the ports that come in, and rays that left the block again of those that leave, mi.Ray3f."""
    sums: sp.csr_matrix
    """Weights of these in each port, shape (ports that come in, then ports that leave, lines)."""
    leaving: sp.csr_matrix
    """Radiance of each port for the light in cells and voxels, shape (ports, cells + voxels)."""
    seen: RecordedPaths
    """Paths of the pixels."""
    mirror: RecordedPaths
    """These with more of their rays, for what a glossy object mirrors."""

    @classmethod
    def of(cls, world: LitWorld, rest: Untouched, followed: Mapping[str, Any]) -> Self:
        """Compresses what is known of an untouched sensor, beside what `follow_ports` gave."""
        into, ports = _ports(world)
        leaving = RecordedPaths.of(
            followed["direct"],
            sp.csr_matrix((followed["data"], followed["indices"], followed["indptr"]), followed["shape"]),
            followed["rays"],
            followed["owner"],
            OUT_PATHS,
        )
        still = [field for name, field in rest.fields.items() if name == ENVIRONMENT]
        whole, room = (
            leaving.response @ _values(world, total([world.darkness(), *fields]))
            for fields in (rest.fields.values(), still)
        )
        coming, back, paths = _coming(world, into), _thinned(leaving, BACK_RAYS), _means(rest.paths)
        table = np.concatenate([coming[0], np.array(back.rays).reshape(-1, 8)])
        owner = np.concatenate([coming[1], into.count + back.owner.astype(np.int64)])
        lines = rays_along(table[:, :3], table[:, 3:WEIGHT])
        weights = (table[:, WEIGHT].astype(np.float64), (owner, np.arange(len(owner))))
        return cls(
            world=world, rest=rest, brought=followed["brought"], into=into, ports=ports, room=room, lines=lines,
            strips=leaving.direct + whole - room,
            sums=sp.csr_matrix(weights, (into.count + ports.count, len(owner))), leaving=leaving.response,
            seen=_thinned(paths, SEEN_RAYS), mirror=_thinned(paths, MIRROR_RAYS),
        )  # fmt: skip

    def image(
        self, target: NearObject | None, pixels: Numbers, *, seed: int, lamp: LampLight | None = None,
        passing: PassingLight | None = None,
    ) -> Array:  # fmt: skip
        """Radiance of some pixels with something before the block, shape (pixels, 3).

        Args:
            target: The object, in its place.
            pixels: Numbers of the pixels, row by row of the film.
            seed: Of the frame.
            lamp: Light of the flashlight, if it shines.
            passing: What passes in the room, in its place.
        """
        world, rest = self.world, self.rest
        found = np.asarray(rest.image.reshape(-1, 3)[pixels], np.float64)
        if lamp is not None:
            found = found + lamp.image(passing, target.scene if target is not None else None)[pixels]
        if passing is not None:
            found = found + rest.paths.seen_of_room(passing, pixels)
        still = world.inventory.environment
        passed, behind = (radiance_of(each, self.lines) for each in (passing, still))
        if lamp is not None:  # what it hides of the room is part of its light
            is_free = ~lamp.is_behind(self.lines)[:, None]
            passed, behind = is_free * passed, is_free * behind
        if target is None:
            if passing is not None:
                values = self._values(self._brought((self.sums @ passed)[: self.brought.shape[1]]))
                found = found + (self.seen.response @ values)[pixels]
            return np.asarray(np.maximum(found, 0))
        stream, hidden = SEEDS_PER_RENDER * seed + ON_OBJECT, np.zeros(())
        own = self.room + target.from_ports * self.strips
        disk = lamp.disk if lamp is not None else None
        now = _Room(still, passing, disk)
        met = target.look(world.scene, now, self.ports, self.lines, behind, rest.light, rays=OBJECT_RAYS, seed=stream)
        if lamp is not None:
            own = own + self.leaving @ self._values(lamp.change)
            hidden = lamp.hidden(target.scene, self.brought)
        lit = met.irradiance(own, np.zeros((len(target.mesh.faces), 3)))
        for _ in range(TURNS):
            changed = self.sums @ met.changes(lit, passed)
            coming, back = np.split(changed, [self.brought.shape[1]])
            values = self._values(self._brought(coming) - hidden)
            shining = own + self.leaving @ values + back
            lit = met.irradiance(shining, lit)
        outside: Any = target
        found = found + (self.seen.response @ values)[pixels]
        seen = rest.paths if target.is_far else self.seen
        found += seen.seen_outside(_Room(still, passing, None), outside, lit, target.finish, pixels)
        if target.finish.specular > 0:
            shining += (1 - target.from_ports) * self.strips
            found += target.mirrored(world.scene, now, self.ports, shining, lit, self.mirror, pixels, seed=seed)
        return np.asarray(np.maximum(found, 0))

    def _brought(self, coming: Array) -> Array:
        """Light in cells and voxels that ports of some radiance bring, shape (cells + voxels, 3)."""
        return np.asarray(_summed(self.brought.T, coming.astype(np.float32)).T, np.float64)

    def _values(self, brought: Array) -> npt.NDArray[np.float32]:
        """Means, as records count them, of what is brought to cells and voxels."""
        dark = self.world.darkness()
        cells = len(dark.fluence)
        field = replace(dark, fluence=brought[:cells], body=brought[cells:])
        return _values(self.world, field)


def follow_ports(world: LitWorld) -> dict[str, npt.NDArray[Any]]:
    """Light through the face of the scene with nothing before it, which the block alone decides, as arrays."""
    into, ports = _ports(world)
    leaving = _leaving(world, ports)
    response = leaving.response
    return {
        "brought": _brought(world, into), "direct": leaving.direct, "data": response.data,
        "indices": response.indices, "indptr": response.indptr, "shape": np.array(response.shape),
        "rays": np.array(leaving.rays), "owner": leaving.owner,
    }  # fmt: skip


def _ports(world: LitWorld) -> tuple[Ports, Ports]:
    """Ports of light that comes in and of light that leaves."""
    footprint = world.elastomer.design.footprint_mm
    return Ports.of(footprint, *INTO), Ports.of(footprint, *OUT)


class _Room(NamedTuple):
    """What shines from all around in one frame."""

    still: Any
    """Where nothing else is, or None."""
    passing: PassingLight | None
    lamp: LampDisk | None

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance that arrives at `si.p` along `-si.wi`, mi.Color3f."""
        parts = [each.eval(si, active) for each in (self.still, self.passing) if each is not None]
        found = sum(parts, mi.Color3f(0))
        return found if self.lamp is None else dr.select(active & self.lamp.met(si), self.lamp.radiance, found)


def _values(world: LitWorld, field: LightField) -> npt.NDArray[np.float32]:
    """Means of the light in cells and voxels, as records count them, shape (elements, 3)."""
    known = field.fluence if world.voxels is None else world.elements(field).values
    return np.asarray(known, np.float32)


def _coming(world: LitWorld, ports: Ports) -> tuple[npt.NDArray[np.float32], Index]:
    """Lines of ports outwards, along which light comes in, with the port of each; what meets the housing has no weight.

    Their columns are those of recorded rays.
    """
    places, ways = ports.lines(INTO_LINES, seed=0)
    rays = rays_along(places, -ways)
    free = ~np.array(world.scene.ray_intersect_preliminary(rays).is_valid())
    table = np.zeros((len(places), 8), np.float32)
    table[:, :3], table[:, 3:WEIGHT], table[:, WEIGHT] = places, -ways, free / INTO_LINES
    return table, ports.owners(INTO_LINES)


def _leaving(world: LitWorld, ports: Ports) -> RecordedPaths:
    """Paths of ports into the block, along which light comes out."""
    places, ways = ports.lines(OUT_PATHS, seed=1)
    lanes, dark = len(places), world.darkness()
    rays = rays_along(places, ways)
    starts = ObjectStarts.of(dr.arange(mi.UInt32, lanes), rays, mi.Float(1), mi.Bool(False))

    def trace(_part: range, room: int) -> tuple[PathRecord, Array]:
        record = PathRecord.empty(room, 1, lanes=lanes)
        seen = world.camera_pass(dark, starts, stream=0, record=record)
        dr.eval(seen, record)
        return record, in_rows(seen)

    centres = world.elements(dark).centres_mm
    found = _means(record_paths(trace, pixels=lanes, centres_mm=centres, samples=1, regions=None))
    owners = ports.owners(OUT_PATHS)
    mean = sp.csr_matrix((np.full(lanes, 1 / OUT_PATHS), (owners, np.arange(lanes))), (ports.count, lanes), np.float32)
    table = np.array(found.rays).reshape(-1, 8)
    table[:, WEIGHT] /= OUT_PATHS
    return RecordedPaths.of(
        mean @ found.direct, sp.csr_matrix(mean @ found.response), table, owners[found.owner], OUT_PATHS
    )


def _brought(world: LitWorld, ports: Ports) -> npt.NDArray[np.float32]:
    """Light that unit radiance in each port brings to cells and voxels, shape (cells + voxels, ports)."""
    places, ways = (each.reshape(-1, ports.bins, PARTICLES, 3) for each in ports.lines(PARTICLES, seed=2))
    patches, size, found = len(places), len(places) * PARTICLES, []
    volumes, scale = world.inventory.volumes_mm3()[:, 0], ports.flux_mm2 / (FIXED_POINT * PARTICLES)
    for bin_ in range(ports.bins):
        origins, directions = (columns(each[:, bin_].reshape(-1, 3)) for each in (places, ways))
        one = dr.full(mi.Float, 1, size)
        starts = LightStarts.escaped(
            dr.arange(mi.UInt32, size), mi.Ray3f(mi.Point3f(*origins), mi.Vector3f(*directions)), mi.Color3f(one), one,
            seed=bin_,
        )  # fmt: skip
        starts.places = dr.arange(mi.UInt32, size) // PARTICLES
        tracks = world.light_pass(starts, lights=patches)
        cells, body = tracks.cells.mean(2) * (scale / volumes), tracks.body.mean(2) * scale
        found.append(np.concatenate([cells, body], 1).astype(np.float32))
    return np.stack(found, 1).reshape(ports.count, -1).T


@kernel()
def _summed(brought, coming):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Sum over ports of what each brings times its radiance, shape (3, elements): most ports meet no object."""
    found = np.zeros((3, brought.shape[1]), np.float32)
    for port in range(len(coming)):
        red, green, blue = coming[port]
        if red != 0 or green != 0 or blue != 0:
            for element in range(brought.shape[1]):
                found[0, element] += red * brought[port, element]
                found[1, element] += green * brought[port, element]
                found[2, element] += blue * brought[port, element]
    return found


def _means(paths: RecordedPaths) -> RecordedPaths:
    """Paths as they are, which know the means of elements alone."""
    return replace(paths, response=sp.csr_matrix(paths.response[:, : paths.response.shape[1] // MOMENTS]))


def _thinned(paths: RecordedPaths, most: int) -> RecordedPaths:
    """Paths with few of their rays, chosen by their weights so that sums are right in the mean."""
    table, first = np.array(paths.rays).reshape(-1, 8), np.array(paths.first).astype(np.int64)
    sums = np.concatenate([[0.0], np.cumsum(table[:, WEIGHT], dtype=np.float64)])
    whole = sums[first[1:]] - sums[first[:-1]]
    owner = np.repeat(np.flatnonzero(whole > 0), most)
    marks = sums[first[owner]] + whole[owner] * np.tile((np.arange(most) + 0.5) / most, len(owner) // most)
    rays = table[np.searchsorted(sums, marks, side="right") - 1]
    rays[:, WEIGHT] = whole[owner] / most
    return RecordedPaths.of(paths.direct, paths.response, rays, owner, most)
