"""Camera pass: rays from the pinhole gather the cached fluence of the cells that they cross.

Inside a cell with isotropic scattering the in-scattered radiance is sigma_s * fluence / (4 pi), so a ray that
crosses a length l gains sigma_s / sigma_t * (1 - exp(-sigma_t l)) * fluence / (4 pi) and loses exp(-sigma_t l), where
the fluence, linear in a cell, is taken at the mean depth of those gains. A ray that meets the object ends there: the
light pass knows how bright it is; only what a glossy surface mirrors goes on. Both branches are followed where a ray
leaves the body, because a coin toss there costs most of the variance.

A medium that scatters forward is not isotropic, and its blur is not that of the reduced one. The first few collisions
of a camera path can be followed with the true phase function; the cached fluence then serves the rest of it.
"""

from typing import Any

from magicsim.light.backend import dr, mi
from magicsim.light.flaws.rough_surfaces import crossing
from magicsim.light.flaws.scatterers import bump_ahead, turned
from magicsim.light.transport.cached_light import CachedLight
from magicsim.light.transport.path_record import Gathered, PathRecord
from magicsim.light.transport.path_starts import PathStarts
from magicsim.light.world.coating import ASKED, after_surface, meet_face, send_on
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import nearer_hit
from magicsim.light.world.medium import (
    Coefficients,
    Constants,
    Media,
    Medium,
    classify,
    free_path,
    fresnel,
    leave,
    scattered,
    scattering_stretch,
)
from magicsim.light.world.next_hit import NOWHERE, Whereabouts, next_hit, whereabouts
from magicsim.light.world.room_light import missed
from magicsim.light.world.shapes import Shapes

ROULETTE_WEIGHT = 1 / 32
"""Rays lighter than this survive in proportion to their weight: efficiency is flat from 1/32 to 1/64, lower above."""
FIRST_STREAM = 0xDA3E39CB94B95BDB
"""PCG32's own first stream."""


@dr.syntax  # type: ignore[untyped-decorator]
def gather_radiance(
    scene: Any, shapes: Shapes, media: Media, light: CachedLight, finish: Finish, starts: PathStarts, *, seed: int,
    max_depth: int, forward: Medium | None, followed: int, record: PathRecord | None,
) -> Any:  # fmt: skip
    """Sum of the radiance of every lane's paths, mi.Color3f."""
    # Opaque: the compiled kernel then serves any seed.
    state = dr.opaque(mi.UInt64, seed)
    sampler = mi.PCG32(size=1, initstate=mi.UInt64(starts.pixel))
    # State of each lane: its path, the branch that waits for its end, the sums.
    start, end = mi.UInt32(starts.begin), mi.UInt32(starts.end)
    index, fresh = mi.UInt32(start), mi.Bool(True)
    place = dr.arange(mi.UInt32, dr.width(starts.pixel))
    ray = dr.zeros(mi.Ray3f, dr.width(starts.pixel))
    weight, radiance = mi.Color3f(1.0), mi.Color3f(0.0)
    waiting, waiting_ray, waiting_weight = mi.Bool(False), mi.Ray3f(ray), mi.Color3f(0.0)
    in_body, depth, active = mi.Bool(False), mi.UInt32(0), mi.Bool(True)
    context = mi.BSDFContext()
    body_pointer, infill_pointer, object_pointer = shapes.pointers()
    constants = Constants.of(media)
    infill, body, ahead = constants.infill, constants.body, Coefficients.of(forward or media.infill)
    environment, lamps = shapes.environment if shapes.room is None else shapes.room, shapes.room is None
    collisions, waiting_collisions, waiting_inside = mi.UInt32(0), mi.UInt32(0), mi.Bool(True)
    at, cells = Whereabouts.unknown(), dr.opaque(mi.UInt32, shapes.cells)
    coating, asked, waiting_asked = shapes.coating, mi.UInt32(0), mi.UInt32(0)
    while active:
        # 1. A fresh lane starts the next path of its pixel.
        if dr.hint(fresh, mode="symbolic"):
            stream = starts.stream(index)
            sampler.seed(state + stream, FIRST_STREAM + stream)
            ray = starts.ray(index)
            weight, in_body, depth = mi.Color3f(starts.weights), mi.Bool(starts.inside), mi.UInt32(starts.depth)
            collisions, waiting = mi.UInt32(0), mi.Bool(False)
            at.kind = mi.UInt32(NOWHERE)
            asked = mi.UInt32(starts.asked)
        # 2. What is met next, by the block's own mesh, the scene or what surrounds it.
        si = next_hit(scene, ray, body_pointer, infill_pointer, shapes.faces, at, active)
        segment = classify(si, body_pointer, infill_pointer, in_body, shapes.openings)
        if shapes.outside is not None:
            si = nearer_hit(shapes.outside, ray, si, active & ~segment.in_body & ~segment.in_infill)
            segment = classify(si, body_pointer, infill_pointer, in_body, shapes.openings)
        valid = si.is_valid()
        cell = shapes.cell(si, segment)
        inside = active & segment.in_infill
        # 3. First collisions in the infill by the true phase function.
        bump = bump_ahead(shapes.scatterers, ray, si, cell, inside)
        scatter, way = mi.Bool(False), mi.Float(0)
        if forward is not None:
            following = inside & (collisions < followed)
            passed = dr.exp(-ahead.sigma_t * bump.length)
            scatter = following & (sampler.next_float32(active) > passed)
            way = free_path(sampler.next_float32(active), passed, ahead.sigma_t)
            weight[scatter] *= ahead.albedo
            collisions[scatter] += 1
            inside &= ~following
        # 4. Light of the cached field along the way through a cell.
        transmitted = dr.select(inside, dr.exp(-infill.sigma_t * bump.length), 1)
        gained = 1 - transmitted
        depth_mm = 1 / infill.sigma_t - bump.length * transmitted * dr.rcp(dr.maximum(gained, 1e-12))
        # Series where the cell is so clear that the difference above loses its digits.
        optical = infill.sigma_t * bump.length
        depth_mm = dr.select(optical > 1e-3, depth_mm, bump.length * (0.5 - optical / 12))  # noqa: PLR2004
        phi = light.cells.at(cell, ray(depth_mm), inside)
        radiance[inside] += weight * phi * gained * (infill.albedo / (4 * dr.pi))
        met = Gathered(
            element=cell, gain=weight.x * gained * (infill.albedo / (4 * dr.pi)), place=ray(depth_mm), active=inside
        )
        arriving = mi.Float(weight.x)
        weight *= transmitted
        # 5. Light and absorption of the body on the way through it.
        crossed = segment.in_body & valid
        if light.body is None:
            weight[crossed] *= dr.exp(-body.sigma_a * si.t)
        else:
            begin, stretch = scattering_stretch(ray, si.t, constants.top_mm)
            kept = dr.exp(-body.sigma_t * stretch)
            chance = sampler.next_float32(active)
            body_way = begin + free_path(chance, kept, body.sigma_t)
            cloud = light.body.along(ray, begin, kept, body.sigma_t, chance, active & crossed)
            before = dr.exp(-body.sigma_a * begin)
            share = (1 - kept) * (body.albedo / (4 * dr.pi))
            radiance[active & crossed] += weight * before * cloud * share
            met = met.otherwise(
                element=cells + light.body.voxels.index(ray(body_way)),
                gain=weight.x * before * share,
                place=ray(body_way),
                active=active & crossed,
            )
            weight[crossed] *= kept * dr.exp(-body.sigma_a * (si.t - stretch))

        # 6. Records, and light of the room for what meets nothing.
        bumps = bump.found & ~scatter
        if record is not None:
            entry = record.number(place, index - start, depth)
            record.add_segment(entry, met)
            record.add_escape(entry, ray, arriving, active & ~valid)
            record.mark(place, dr.select(bumps, ray(bump.length), si.p), active & valid)
        if environment is not None:
            radiance[active & ~valid] += weight * environment.eval(missed(ray), active & ~valid)

        # 7. Reflection and refraction at an interface; the first way out of a path goes on in two branches.
        *smooth, scale = fresnel(si, segment, constants)
        facet = crossing(constants.rough, si, segment, constants.eta(segment.on_infill), tuple(smooth), sampler)
        first_hit = depth == 0
        face = meet_face(coating, si, segment, facet.reflectance, sampler, active)
        reflectance, interface = face.reflectance, segment.on_body & ~face.painted
        weight *= face.kept
        leaving = interface & ~segment.entering & (reflectance < 1) & ~scatter
        split = leaving & ~waiting
        reflect = ~first_hit & ~split & (sampler.next_float32(active) < reflectance)
        known = first_hit | split
        dielectric = (interface | segment.on_infill) & ~scatter & ~bumps
        local = dr.select(reflect, facet.reflected, facet.refracted)
        local = facet.onward(local, reflect, active & dielectric)
        through = facet.crosses(local, reflect)
        branch = dr.select(known, 1 - reflectance, 1) * dr.select(through, scale, 1)
        keep_reflected = dr.minimum(dr.max(weight) * reflectance / ROULETTE_WEIGHT, 1)
        set_aside = active & split & (sampler.next_float32(active) < keep_reflected)
        back = facet.onward(facet.reflected, mi.Bool(True), set_aside)
        through = facet.crosses(back, mi.Bool(True))
        waiting_weight[set_aside] = weight * reflectance * dr.rcp(dr.maximum(keep_reflected, 1e-9))
        waiting_weight[set_aside & through] *= scale
        waiting_inside[set_aside] = ~through
        waiting_ray[set_aside] = leave(si, si.to_world(back))
        waiting_collisions[set_aside] = collisions
        waiting_asked[set_aside] = after_surface(coating, si, asked, interface & ~segment.entering, mi.Bool(True))
        waiting |= set_aside
        weight[dielectric] *= branch

        # 8. Surfaces that end or turn a path: object, opaque shapes with their lamps, paint.
        sample1 = sampler.next_float32(active)
        sample2 = mi.Point2f(sampler.next_float32(active), sampler.next_float32(active))
        on_object = active & segment.opaque & (si.shape == object_pointer)
        radiance[on_object] += weight * light.on_object(si.prim_index, on_object) * finish.diffuse(si, on_object)
        mirrored, share = finish.mirror(si, sample2)
        weight[on_object] *= share
        local = dr.select(on_object, mirrored, local)
        opaque = active & segment.opaque & ~on_object
        if dr.hint(opaque, mode="symbolic"):
            radiance += weight * si.emitter(scene).eval(si, opaque & (asked == 0) & lamps)
            bs, value = si.bsdf(ray).sample(context, si, sample1, sample2, opaque)
            local = bs.wo
            weight *= value
        on = send_on(coating, scene, si, segment, face, constants, (sample1, sample2), sampler, depth == 1, active)
        radiance += weight * on.lit if coating is not None and lamps else 0
        local = dr.select(face.painted, on.local, local)
        weight *= on.share
        passed = after_surface(coating, si, asked, interface & ~segment.entering, reflect)
        asked = dr.select(on.asks, mi.UInt32(ASKED), passed)
        # 9. The next ray: from the surface, past an inclusion, or from a collision.
        outward = mi.Frame3f.cos_theta(local) > 0
        in_body = dr.select(segment.on_body, ~outward, dr.select(segment.on_infill, outward, segment.in_body))
        spawned = leave(si, si.to_world(local))
        past = turned(shapes.scatterers, ray, bump, sampler)
        weight[active & bumps] *= past.share
        spawned.o = dr.select(bumps, past.place, spawned.o)
        spawned.d = dr.select(bumps, past.direction, spawned.d)
        in_body &= ~bumps
        if forward is not None:
            in_body = dr.select(scatter, segment.in_body, in_body)
            spawned.o = dr.select(scatter, ray(way), spawned.o)
            spawned.d = dr.select(scatter, scattered(ray.d, sample2, ahead.anisotropy), spawned.d)
        ray = mi.Ray3f(spawned)
        at = whereabouts(si, segment.on_infill, scatter | bumps, in_body, shapes.faces)
        depth += 1
        # 10. Russian roulette; what has ended makes place for the waiting branch, then for the next sample.
        survive = dr.minimum(dr.max(weight) / ROULETTE_WEIGHT, 1)
        keep = sampler.next_float32(active) < survive
        weight *= dr.rcp(dr.maximum(survive, 1e-9))
        alive = valid & keep & (dr.max(weight) > 0) & (depth < max_depth)
        resume = active & ~alive & waiting & (depth < max_depth)
        ray = dr.select(resume, waiting_ray, ray)
        weight = dr.select(resume, waiting_weight, weight)
        collisions = dr.select(resume, waiting_collisions, collisions)
        in_body = dr.select(resume, waiting_inside, in_body)
        asked = dr.select(resume, waiting_asked, asked)
        at.kind[resume] = NOWHERE
        waiting &= ~resume
        # A lane takes the samples of its pixel one after the other, so that few wait for the longest path of all.
        fresh = active & ~(alive | resume)
        index[fresh] += 1
        active &= ~fresh | (index < end)
    dr.eval(radiance)  # the compiled kernel then serves any size of what it becomes
    return radiance
