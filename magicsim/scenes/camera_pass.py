"""Camera pass: rays from the pinhole gather the cached fluence of the cells that they cross.

Inside a cell with isotropic scattering the in-scattered radiance is sigma_s * fluence / (4 pi), so a ray that
crosses a length l gains sigma_s / sigma_t * (1 - exp(-sigma_t l)) * fluence / (4 pi) and loses exp(-sigma_t l).
A ray that meets the object ends there: the light pass knows how bright it is. Both branches are followed where a ray
leaves the body, because a coin toss there costs most of the variance.
"""

from typing import Any

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.medium import Media, Shapes, classify, fresnel
from magicsim.scenes.sequence import sequence

ROULETTE_WEIGHT = 1 / 32
"""Rays lighter than this survive in proportion to their weight: efficiency is flat from 1/32 to 1/64, lower above."""
PATTERN_SEED = 1
"""Of the first pixel pattern, a fixed quadrature for all seeds: only chance at interfaces depends on the seed."""


@dr.syntax  # type: ignore[untyped-decorator]
def gather_radiance(
    scene: Any, shapes: Shapes, media: Media, fluence: Any, exitance: Any, *, samples: int, seed: int, max_depth: int,
    pattern: int = 0,
) -> Any:  # fmt: skip
    """Radiance of every pixel of the scene's first sensor.

    Args:
        scene: The loaded scene.
        shapes: Body, infill and object.
        media: Optical constants.
        fluence: mi.Float of size 3 * cells.
        exitance: Radiance that the object's triangles send out, mi.Float of size 3 * triangles.
        samples: Camera samples a pixel.
        seed: Random stream of the choices at interfaces.
        max_depth: Longest path.
        pattern: Another number shifts every pixel's pattern at random, so that the errors of images are independent.

    Returns:
        mi.Float of size rows * columns * 3.
    """
    sensor = scene.sensors()[0]
    columns, rows = sensor.film().size()
    count = columns * rows * samples
    # Opaque: the compiled kernel then serves any number of samples and any seed.
    per_pixel = dr.opaque(mi.UInt32, samples)
    lane = dr.arange(mi.UInt32, count)
    pixel, index = lane // per_pixel, lane % per_pixel
    shifts = mi.PCG32(size=columns * rows, initstate=dr.opaque(mi.UInt64, PATTERN_SEED + pattern))
    shift = [dr.gather(mi.UInt32, shifts.next_uint32(), pixel) for _ in range(2)]
    jitter = mi.Point2f(*sequence(index, shift))
    position = mi.Point2f(
        (mi.Float(pixel % columns) + jitter.x) / columns, (mi.Float(pixel // columns) + jitter.y) / rows
    )
    sampler = mi.PCG32(size=count, initstate=dr.opaque(mi.UInt64, seed))
    ray = mi.Ray3f(sensor.sample_ray(mi.Float(0), mi.Float(0.5), position, mi.Point2f(0.5, 0.5))[0])
    weight, radiance = mi.Color3f(1.0), mi.Color3f(0.0)
    waiting, waiting_ray, waiting_weight = mi.Bool(False), mi.Ray3f(ray), mi.Color3f(0.0)
    in_body, depth, active = mi.Bool(False), mi.UInt32(0), mi.Bool(True)
    context = mi.BSDFContext()
    body_pointer, infill_pointer, object_pointer = shapes.pointers()
    triangles_per_cell = shapes.triangles_per_cell
    environment = scene.environment()
    while active:
        si = scene.ray_intersect(ray, active)
        valid = si.is_valid()
        segment = classify(si, body_pointer, infill_pointer, in_body)
        transmitted = dr.select(segment.in_infill, dr.exp(-media.sigma_t * si.t), 1)
        cell = si.prim_index // triangles_per_cell
        inside = active & segment.in_infill
        phi = mi.Color3f(*[dr.gather(mi.Float, fluence, cell * 3 + c, inside) for c in range(3)])
        source = (1 - transmitted) * (media.sigma_s / media.sigma_t / (4 * dr.pi))
        radiance[inside] += weight * phi * source
        weight *= transmitted
        weight[segment.in_body & valid] *= dr.exp(-media.body_absorption * si.t)

        if environment is not None:
            radiance[active & ~valid] += weight * environment.eval(si, active & ~valid)

        reflectance, reflected, refracted, scale = fresnel(si, segment, media)
        first_hit = depth == 0
        leaving = segment.on_body & ~segment.entering & (reflectance < 1)
        split = leaving & ~waiting
        reflect = ~first_hit & ~split & (sampler.next_float32(active) < reflectance)
        known = first_hit | split
        dielectric = segment.on_body | segment.on_infill
        local = dr.select(reflect, reflected, refracted)
        branch = dr.select(known, 1 - reflectance, 1) * dr.select(reflect, 1, scale)
        keep_reflected = dr.minimum(dr.max(weight) * reflectance / ROULETTE_WEIGHT, 1)
        set_aside = active & split & (sampler.next_float32(active) < keep_reflected)
        waiting_weight[set_aside] = weight * reflectance * dr.rcp(dr.maximum(keep_reflected, 1e-9))
        waiting_ray[set_aside] = si.spawn_ray(si.to_world(reflected))
        waiting |= set_aside
        weight[dielectric] *= branch

        sample1 = sampler.next_float32(active)
        sample2 = mi.Point2f(sampler.next_float32(active), sampler.next_float32(active))
        on_object = active & segment.opaque & (si.shape == object_pointer)
        sent = mi.Color3f(*[dr.gather(mi.Float, exitance, si.prim_index * 3 + c, on_object) for c in range(3)])
        radiance[on_object] += weight * sent
        weight[on_object] = 0
        opaque = active & segment.opaque & ~on_object
        if dr.hint(opaque, mode="symbolic"):
            radiance += weight * si.emitter(scene).eval(si, opaque)
            bs, value = si.bsdf(ray).sample(context, si, sample1, sample2, opaque)
            local = bs.wo
            weight *= value
        outward = mi.Frame3f.cos_theta(local) > 0
        in_body = dr.select(segment.on_body, ~outward, dr.select(segment.on_infill, outward, segment.in_body))
        ray = si.spawn_ray(si.to_world(local))
        depth += 1
        survive = dr.minimum(dr.max(weight) / ROULETTE_WEIGHT, 1)
        keep = sampler.next_float32(active) < survive
        weight *= dr.rcp(dr.maximum(survive, 1e-9))
        alive = valid & keep & (dr.max(weight) > 0) & (depth < max_depth)
        resume = active & ~alive & waiting & (depth < max_depth)
        ray = dr.select(resume, waiting_ray, ray)
        weight = dr.select(resume, waiting_weight, weight)
        in_body |= resume
        waiting &= ~resume
        active &= alive | resume
    image = [dr.block_sum(radiance[channel], samples) / samples for channel in range(3)]
    return dr.ravel(mi.Color3f(*image))
