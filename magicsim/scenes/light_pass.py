"""Light pass: particles from the lights fill every infill cell with fluence (track-length estimator).

Where they meet the object they add to its irradiance.

Deposits are integers in fixed point, because floating-point scatter-adds have no fixed order.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.medium import Media, Shapes, classify, fresnel
from magicsim.scenes.sequence import sequence

FIXED_POINT = 2.0**24
"""Integer steps per unit of (relative weight x mm)."""
ROULETTE_DEPTH = 32
SEQUENCE = 2**32
"""Offset that keeps the random streams of particles apart from the camera's."""


@dr.syntax  # type: ignore[untyped-decorator]
def deposit_tracks(
    scene: Any, emitter: Any, shapes: Shapes, media: Media, *, first: int, particles: int, seed: int, max_depth: int,
) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint64]]:  # fmt: skip
    """Traces particles from one light and adds up weight x path length per cell and channel.

    Args:
        scene: The loaded scene.
        emitter: The light.
        shapes: Body, infill and object.
        media: Optical constants.
        first: Index of the first particle, so that a large number can be traced in chunks.
        particles: Number of particles of this chunk.
        seed: Random stream of the light.
        max_depth: Longest path.

    Returns:
        Fixed-point deposits in cells, shape (3 * cells,): flux x mm times `FIXED_POINT` times the number of all
        particles; and on the object's triangles, shape (3 * triangles,): flux, in the same units.
    """
    # Opaque: the compiled kernel then serves any seed and chunk.
    sampler = mi.PCG32(
        size=particles, initstate=dr.opaque(mi.UInt64, seed), initseq=dr.opaque(mi.UInt64, SEQUENCE + first)
    )
    start = mi.PCG32(size=1, initstate=dr.opaque(mi.UInt64, seed))
    u = sequence(dr.opaque(mi.UInt32, first) + dr.arange(mi.UInt32, particles), [start.next_uint32() for _ in range(4)])
    emitted = emitter.sample_ray(mi.Float(0), mi.Float(0.5), mi.Point2f(u[0], u[1]), mi.Point2f(u[2], u[3]))
    ray = mi.Ray3f(emitted[0])
    weight = mi.Color3f(emitted[1])
    brightest = dr.max(weight)
    deposits = dr.zeros(mi.UInt64, 3 * shapes.cells)
    landed = dr.zeros(mi.UInt64, 3 * shapes.object_triangles)
    triangles_per_cell = shapes.triangles_per_cell
    in_body = mi.Bool(True)
    depth, active = mi.UInt32(0), mi.Bool(brightest > 0)
    context = mi.BSDFContext(mi.TransportMode.Importance)
    body_pointer, infill_pointer, object_pointer = shapes.pointers()
    while active:
        si = scene.ray_intersect(ray, active)
        segment = classify(si, body_pointer, infill_pointer, in_body)
        # Expected track length up to the next collision or wall, instead of the sampled one.
        transmitted = dr.exp(-media.sigma_t * si.t)
        length = (1 - transmitted) / media.sigma_t
        cell = si.prim_index // triangles_per_cell
        for channel in range(3):
            amount = mi.UInt64(weight[channel] * length * FIXED_POINT)
            dr.scatter_add(deposits, amount, cell * 3 + channel, active & segment.in_infill)
        scatter = segment.in_infill & (sampler.next_float32(active) > transmitted)
        # Inverse of the truncated exponential: where inside the cell the collision happens.
        free_path = -dr.log(1 - sampler.next_float32(active) * (1 - transmitted)) / media.sigma_t
        weight[scatter] *= media.sigma_s / media.sigma_t
        weight[segment.in_body & si.is_valid()] *= dr.exp(-media.body_absorption * si.t)

        reflectance, reflected, refracted = fresnel(si, segment, media)[:3]
        choice = sampler.next_float32(active)
        reflect = choice < reflectance
        local = dr.select(reflect, reflected, refracted)
        sample1 = sampler.next_float32(active)
        sample2 = mi.Point2f(sampler.next_float32(active), sampler.next_float32(active))
        opaque = active & segment.opaque
        for channel in range(3):
            amount = mi.UInt64(weight[channel] * FIXED_POINT)
            dr.scatter_add(landed, amount, si.prim_index * 3 + channel, opaque & (si.shape == object_pointer))
        if dr.hint(opaque, mode="symbolic"):
            bs, value = si.bsdf(ray).sample(context, si, sample1, sample2, opaque)
            local = bs.wo
            weight *= value
        outward = mi.Frame3f.cos_theta(local) > 0
        in_body = dr.select(segment.on_body, ~outward, dr.select(segment.on_infill, outward, segment.in_body))
        spawned = si.spawn_ray(si.to_world(local))
        ray.o = dr.select(scatter, ray(free_path), spawned.o)
        ray.d = dr.select(scatter, mi.warp.square_to_uniform_sphere(sample2), spawned.d)
        depth += 1
        survive = dr.minimum(dr.max(weight) / brightest, 1)
        roulette = depth > ROULETTE_DEPTH
        keep = sampler.next_float32(active) < survive
        weight[roulette] *= dr.rcp(dr.maximum(survive, 1e-6))
        active &= si.is_valid() & (dr.max(weight) > 0) & (depth < max_depth) & (~roulette | keep)
    return np.array(deposits), np.array(landed)


def cell_volumes_mm3(
    vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int32], cells: int
) -> npt.NDArray[np.float64]:
    """Volume of each deformed cell by the divergence theorem, shape (cells,) [mm3].

    Args:
        vertices: Shape (vertices, 3) [mm].
        faces: Cell-major vertex indices, shape (triangles, 3).
        cells: Number of cells.
    """
    corners = vertices[faces].reshape(cells, -1, 3, 3)
    corners = corners - corners[:, :1, :1]
    return np.asarray(np.einsum("cti,cti->c", corners[:, :, 0], np.cross(corners[:, :, 1], corners[:, :, 2])) / 6)
