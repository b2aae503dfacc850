"""Light pass: particles from the lights fill every infill cell with fluence (track-length estimator).

A body that scatters is filled voxel by voxel, each segment at one random point of it. Where particles meet the object
they add to its irradiance.

Deposits are integers in fixed point, because floating-point scatter-adds have no fixed order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.arrays import Array, Counts
from magicsim.errors import RenderError
from magicsim.light.backend import copied, dr, in_rows, mi
from magicsim.light.flaws.rough_surfaces import crossing
from magicsim.light.flaws.scatterers import bump_ahead, turned
from magicsim.light.transport.cached_light import Voxels
from magicsim.light.transport.light_starts import TURNS, LightStarts
from magicsim.light.transport.recorded_light import LightRecord, take_down
from magicsim.light.world.coating import bounced, meet_face
from magicsim.light.world.loaded_scene import nearer_hit
from magicsim.light.world.medium import (
    Constants,
    Media,
    classify,
    free_path,
    fresnel,
    leave,
    scattered,
    scattering_stretch,
)
from magicsim.light.world.next_hit import NOWHERE, Whereabouts, next_hit, whereabouts
from magicsim.light.world.shapes import Shapes

LARGEST_SUM = 2.0**63
"""Half of what the integers hold."""
ROULETTE_DEPTH = 32
SEQUENCE = 2**32
"""Offset that keeps the random streams of particles apart from the camera's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracks:
    """What particles left behind: flux times the steps of their light times the number of all of them, as integers."""

    cells: Counts
    """Flux x path length in each infill cell, shape (lights, cells, 3) [mm]."""
    body: Counts
    """Flux x path length in each voxel of the body, shape (lights, voxels, 3) [mm]; one voxel where it is clear."""
    landed: Counts
    """Flux on each of the object's triangles, shape (lights, triangles, 3)."""
    balance: dict[str, Array] | None = None
    """Flux of each channel, shape (3,), summed over a chunk's particles: `emitted`, absorbed in a `clear_body` and by
    `surfaces`, `escaped`, and `ended` with paths, less what roulette gave to others; if that was asked for."""


def sum_tracks(parts: Sequence[Tracks]) -> Tracks:
    """Sum of several chunks, without their accounts of light; `RenderError` where integers have too few digits."""
    cells, body, landed = (_added([getattr(part, name) for part in parts]) for name in ("cells", "body", "landed"))
    return Tracks(cells=cells, body=body, landed=landed)


def _added(parts: Sequence[Counts]) -> Counts:
    if np.sum(parts, axis=0, dtype=np.float64).max() > LARGEST_SUM:
        raise RenderError(
            "so bright a light has too many particles for the digits that are kept: lower render.particles or "
            "render.anchor_particles, or the radiances of rig.strips, rig.flashlight and rig.ambient alike"
        )
    return np.asarray(np.sum(parts, axis=0, dtype=np.uint64))


@dr.syntax  # type: ignore[untyped-decorator]
def deposit_tracks(
    scene: Any, starts: LightStarts, shapes: Shapes, media: Media, voxels: Voxels | None, *, lights: int,
    max_depth: int, balance: bool, record: LightRecord | None,
) -> Tracks:  # fmt: skip
    """Traces particles and adds up weight x path length per cell and channel.

    Scattering is followed as the media say it: reduced, or by the true phase function. Voxels are None where the body
    does not scatter; each light has deposits of its own; `balance` keeps account of where the light goes, `record`
    takes down what leaves.
    """
    lanes = -(-starts.particles // TURNS)
    # Opaque: the compiled kernel then serves any chunk.
    end, number, stride = mi.UInt32(starts.count), dr.arange(mi.UInt32, lanes), dr.opaque(mi.UInt32, lanes)
    # State of each lane: its particle, the sums of weight x length, where the light goes.
    sampler = mi.PCG32(size=1, initstate=mi.UInt64(number))
    ray, weight, brightest, steps = dr.zeros(mi.Ray3f, lanes), mi.Color3f(0.0), mi.Float(0), mi.Float(0)
    sizes = [shapes.cells, voxels.count if voxels is not None else 1, shapes.object_triangles]
    deposits, clouded, landed = (dr.zeros(mi.UInt64, copied(3 * size * lights)) for size in sizes)
    cells, boxes, triangles, deepest = (dr.opaque(mi.UInt32, number) for number in (*sizes, max_depth))
    light = dr.zeros(mi.UInt32, lanes)
    constants = Constants.of(media)
    infill, body = constants.infill, constants.body
    in_body, fresh = mi.Bool(False), mi.Bool(True)
    depth, active = mi.UInt32(0), number < end
    context = mi.BSDFContext(mi.TransportMode.Importance)
    body_pointer, infill_pointer, object_pointer = shapes.pointers()
    source, absorbed, stopped, escaped, ended = (mi.Color3f(0.0) for _ in range(5))
    at = Whereabouts.unknown()
    while active:
        # 1. A fresh lane starts its next particle.
        if dr.hint(fresh, mode="symbolic"):
            there = number < end
            stream = dr.gather(mi.UInt64, starts.streams, number, there)
            sampler.seed(dr.gather(mi.UInt64, starts.seeds, number, there), SEQUENCE + stream)
            ray = starts.ray(number, there)
            weight = dr.gather(mi.Color3f, starts.weights, number, there)
            brightest = dr.gather(mi.Float, starts.brightest, number, there)
            steps = dr.gather(mi.Float, starts.steps, number, there)
            light = dr.gather(mi.UInt32, starts.places, number, there)
            in_body, depth = dr.gather(mi.Bool, starts.inside, number, there), mi.UInt32(0)
            at.kind = mi.UInt32(NOWHERE)
            if balance:
                source += weight
        # 2. What is met next, by the block's own mesh, the scene or what surrounds it.
        si = next_hit(scene, ray, body_pointer, infill_pointer, shapes.faces, at, active)
        segment = classify(si, body_pointer, infill_pointer, in_body, shapes.openings)
        if shapes.outside is not None:
            si = nearer_hit(shapes.outside, ray, si, active & ~segment.in_body & ~segment.in_infill)
            segment = classify(si, body_pointer, infill_pointer, in_body, shapes.openings)
        take_down(record, light, starts, number, ray, weight, brightest, active & ~si.is_valid())
        # 3. Deposits of the infill, and whether the particle collides in it.
        cell = shapes.cell(si, segment)
        bump = bump_ahead(shapes.scatterers, ray, si, cell, active & segment.in_infill)
        # Expected track length up to the next collision or wall, instead of the sampled one.
        transmitted = dr.exp(-infill.sigma_t * bump.length)
        length = (1 - transmitted) / infill.sigma_t
        cell += light * cells
        # Most lights have one colour, and adding nothing takes as long as adding something.
        for channel in range(3):
            amount = mi.UInt64(weight[channel] * length * steps)
            dr.scatter_add(deposits, amount, cell * 3 + channel, active & segment.in_infill & (amount > 0))
        scatter = segment.in_infill & (sampler.next_float32(active) > transmitted)
        way = free_path(sampler.next_float32(active), transmitted, infill.sigma_t)
        weight[scatter] *= infill.albedo
        bumps = bump.found & ~scatter
        # 4. Deposits, collisions and absorption of the body.
        crossed = segment.in_body & si.is_valid()
        carried = mi.Color3f(weight)
        collide, clear_mm = mi.Bool(False), si.t
        if voxels is not None:
            # Clear of scattering above the block, in the lens plate.
            begin, stretch = scattering_stretch(ray, si.t, constants.top_mm)
            passed = dr.exp(-body.sigma_t * stretch)
            body_way = begin + free_path(sampler.next_float32(active), passed, body.sigma_t)
            body_length = (1 - passed) / body.sigma_t
            place = light * boxes + voxels.index(ray(body_way))
            for channel in range(3):
                amount = mi.UInt64(weight[channel] * body_length * steps)
                dr.scatter_add(clouded, amount, place * 3 + channel, active & crossed & (amount > 0))
            collide = crossed & (sampler.next_float32(active) > passed)
            clear_mm = dr.select(collide, begin, si.t - stretch)
            way = dr.select(collide, body_way, way)
        weight[crossed] *= dr.exp(-body.sigma_a * clear_mm)
        if balance:
            absorbed += dr.select(active, carried - weight, 0)
        weight[collide] *= body.albedo
        scatter |= collide | bumps

        # 5. Reflection or refraction at an interface, by chance.
        smooth = fresnel(si, segment, constants)[:3]
        met = crossing(constants.rough, si, segment, constants.eta(segment.on_infill), smooth, sampler)
        face = meet_face(shapes.coating, si, segment, met.reflectance, sampler, active & ~scatter)
        reflectance = face.reflectance
        stopped += dr.select(active, weight * (1 - face.kept), 0) if balance else 0
        weight *= face.kept
        choice = sampler.next_float32(active)
        reflect = choice < reflectance
        local = dr.select(reflect, met.reflected, met.refracted)
        local = met.onward(local, reflect, active & ~scatter & ~face.painted)
        # 6. What lands on the object, and surfaces that absorb or turn: opaque shapes, paint, inclusions.
        sample1 = sampler.next_float32(active)
        sample2 = mi.Point2f(sampler.next_float32(active), sampler.next_float32(active))
        opaque = active & segment.opaque & ~scatter
        triangle = light * triangles + si.prim_index
        for channel in range(3):
            amount = mi.UInt64(weight[channel] * steps)
            dr.scatter_add(landed, amount, triangle * 3 + channel, opaque & (si.shape == object_pointer))
        if dr.hint(opaque, mode="symbolic"):
            bs, value = si.bsdf(ray).sample(context, si, sample1, sample2, opaque)
            local = bs.wo
            if balance:
                stopped += weight * (1 - value)
            weight *= value
        away, share = bounced(shapes.coating, si, face, sample1, sample2)
        local = dr.select(face.painted, away, local)
        stopped += weight * (1 - share) if balance else 0
        weight *= share
        on = turned(shapes.scatterers, ray, bump, sampler)
        stopped += dr.select(active & bumps, weight * (1 - on.share), 0) if balance else 0
        weight[bumps] *= on.share
        # 7. The next ray: from the surface, past an inclusion, or from a collision.
        outward = mi.Frame3f.cos_theta(local) > 0
        arrived = dr.select(segment.on_body, ~outward, dr.select(segment.on_infill, outward, segment.in_body))
        in_body = dr.select(scatter, segment.in_body, arrived)
        spawned = leave(si, si.to_world(local))
        ray.o = dr.select(bumps, on.place, dr.select(scatter, ray(way), spawned.o))
        scattered_to = dr.select(
            segment.in_infill, scattered(ray.d, sample2, infill.anisotropy), scattered(ray.d, sample2, body.anisotropy)
        )
        ray.d = dr.select(bumps, on.direction, dr.select(scatter, scattered_to, spawned.d))
        at = whereabouts(si, segment.on_infill & ~collide, segment.in_infill & scatter, in_body, shapes.faces)
        depth += 1
        # 8. Russian roulette, and which lanes go on.
        survive = dr.minimum(dr.max(weight) / brightest, 1)
        roulette = depth > ROULETTE_DEPTH
        keep = sampler.next_float32(active) < survive
        carried = mi.Color3f(weight)
        weight[roulette] *= dr.rcp(dr.maximum(survive, 1e-6))
        going = si.is_valid() & (dr.max(weight) > 0) & (depth < deepest) & (~roulette | keep)
        if balance:
            escaped += dr.select(active & ~si.is_valid(), carried, 0)
            ended += dr.select(active & si.is_valid(), carried - dr.select(going, weight, 0), 0)
        # A lane whose particle has ended takes another one, so that few wait for the longest path of all.
        fresh = active & ~going
        number[fresh] += stride
        active &= ~fresh | (number < end)
    parts = (source, absorbed, stopped, escaped, ended) if balance else ()
    account = [in_rows(part + dr.zeros(mi.Color3f, lanes)).T.sum(1) for part in parts]
    names = ("emitted", "clear_body", "surfaces", "escaped", "ended")
    return Tracks(
        cells=np.array(deposits)[: 3 * lights * sizes[0]].reshape(lights, -1, 3),
        body=np.array(clouded)[: 3 * lights * sizes[1]].reshape(lights, -1, 3),
        landed=np.array(landed)[: 3 * lights * sizes[2]].reshape(lights, -1, 3),
        balance=dict(zip(names, account, strict=True)) if balance else None,
    )
