"""A facing finger against the path tracer with two whole sensors in one scene, and against what it must do."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.light.facing.finger import FacingFinger
from magicsim.light.records.untouched import UntouchedStates
from magicsim.light.renderer import Renderer
from magicsim.scenes.timeline import UNTOUCHED, View
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.usefixtures("untouched_once")
DISTANCE_MM = 12.0
AGREEMENT = 0.06
"""Of the light that the other finger adds: its face counts as glowing alike in all directions, in two-millimetre
squares, and as sending back diffusely what falls on it."""

FEW_PIXELS = ("rig.camera.columns=24", "rig.camera.rows=32")


def traced_pair(sensor, *, samples, seed):
    """Mean radiance of each channel by the path tracer, the whole other sensor before this one."""
    from magicsim.geometry.mesh import SurfaceMesh
    from magicsim.light.backend import mi
    from magicsim.light.plain_renderer import PATHS
    from magicsim.light.world import scene_dict as world
    from magicsim.light.world.finish import Finish
    from magicsim.light.world.shapes import mesh_shape

    elastomer, rig, turn = sensor.elastomer, sensor.rig, np.diag([-1.0, 1.0, -1.0])
    shift = np.array([0.0, 0.0, -DISTANCE_MM])
    content = world.WorldContent(object_mesh=None, object_finish=Finish(), flashlight=False)
    scene = world.scene_dict(elastomer, rig, content, world.block_shapes(elastomer, rig)) | {"integrator": PATHS}
    move = np.eye(4)
    move[:3, :3], move[:3, 3] = turn, shift
    for index, strip in enumerate(rig.strips):
        other = world.strip_entry(strip, elastomer)
        other["to_world"] = mi.ScalarTransform4f(move) @ other["to_world"]
        scene[f"other{index}"] = other
    body_medium = world.medium_of(elastomer.design.materials.body)
    infill = elastomer.design.materials.infill
    ior = elastomer.design.materials.body.ior

    def moved(vertices):
        return vertices @ turn.T + shift

    body = SurfaceMesh(
        vertices=moved(world.with_lens(elastomer.body.vertices, elastomer, rig)), faces=elastomer.body.faces
    )
    cells = SurfaceMesh(vertices=moved(elastomer.infill.vertices), faces=elastomer.infill.faces)
    clear = {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    scene["other_body"] = mesh_shape(body, "other_body", clear, interior=body_medium)
    scene["other_infill"] = mesh_shape(
        cells, "other_infill", {"type": "dielectric", "int_ior": infill.ior, "ext_ior": ior},
        interior=world.medium_of(infill), exterior=body_medium,
    )  # fmt: skip
    image = mi.render(mi.load_dict(scene), spp=samples, seed=seed)
    return np.array(image, np.float64).mean((0, 1))


def means(scene, distance_mm, seeds, untouched):
    found = []
    for seed in seeds:
        sensor = Sensor.for_scene(scene.model_copy(update={"seed": seed}), untouched=untouched)
        state = replace(UNTOUCHED, facing_mm=distance_mm)
        found.append(sensor.radiance(state, sensor.rest).mean((0, 1), dtype=np.float64))
    return np.mean(found, 0), np.std(found, 0, ddof=1) / np.sqrt(len(found))


@pytest.mark.slow
def test_facing_finger_adds_the_light_that_a_path_tracer_with_two_sensors_finds(small_scene):
    anchored = ("render.anchor_samples=32", "render.anchor_particles=1200000", "render.particles=60000")
    scene, untouched = small_scene("rest", *anchored), UntouchedStates()
    alone, _ = means(scene, None, range(2), untouched)
    both, error = means(scene, DISTANCE_MM, range(3), untouched)
    path = Sensor.for_scene(small_scene("rest", "render.estimator=path", "render.samples=200"))
    traced_alone = path.renderer.plain_radiance(View()).mean((0, 1), dtype=np.float64)
    pairs = [traced_pair(path, samples=200, seed=seed) for seed in range(3)]
    traced, path_error = np.mean(pairs, 0), np.std(pairs, 0, ddof=1) / np.sqrt(len(pairs))
    added, expected = both - alone, traced - traced_alone
    noise = np.hypot(error, 1.5 * path_error) / expected
    assert noise.max() < AGREEMENT, "too noisy to tell anything"
    assert (np.abs(added / expected - 1) < AGREEMENT + 2 * noise).all(), f"{added / expected}, noise {noise}"


def test_far_finger_is_as_none_and_a_near_one_is_the_brighter_the_nearer(small_scene):
    anchored = ("render.anchor_samples=4", "render.anchor_particles=60000", "render.particles=6000")
    sensor = Sensor.for_scene(small_scene("rest", *anchored, *FEW_PIXELS))
    states = [replace(UNTOUCHED, facing_mm=at) for at in (None, 1900.0, 20.0, 8.0)]
    alone, far, near, nearer = (sensor.radiance(state, sensor.rest).mean((0, 1)) for state in states)
    np.testing.assert_allclose(far, alone, rtol=1e-3)
    assert (near > 1.05 * alone).all()
    assert (nearer > near).all()
    share = sensor.renderer.as_finger()[1].reflectance
    assert ((share > 0.05) & (share < 0.6)).all()


def test_companion_is_lit_and_seen_as_an_object_in_its_place(small_scene):
    anchored = ("render.anchor_samples=4", "render.anchor_particles=60000", "render.particles=6000")
    sensor = Sensor.for_scene(small_scene("near", *anchored, *FEW_PIXELS, "object.radius_mm=3"))
    twin = sensor.object.surface()
    colors = np.tile(np.array(sensor.object.color), (len(twin.vertices), 1))
    companion = replace(twin, colors=colors)
    alone = replace(UNTOUCHED, facing_mm=DISTANCE_MM)
    there = replace(alone, gap_mm=0.5, x_mm=1.0)
    beside = replace(alone, companion=sensor.indenter(there).pose.key())
    plain = sensor.renderer
    finger = FacingFinger.of(*plain.as_finger(), plain.object_mesh, plain.object_finish, companion)
    renderer = Renderer(
        plain.elastomer, plain.rig, plain.settings, seed=plain.seed,
        facing=replace(finger, beside=(0, 0)),  # as many rays to what stands beside the object as to the object
    )  # fmt: skip
    without, as_object, as_companion = (
        renderer.render(sensor.view(each, sensor.rest))[0] for each in (alone, there, beside)
    )
    changed = np.abs(as_object - without).mean()
    assert changed > 0.01 * without.mean(), "too little changes to tell anything"
    assert np.abs(as_companion - as_object).mean() < 0.02 * changed
    fewer = plain.facing_another(plain, companion).render(sensor.view(beside, sensor.rest))[0]
    change, noisier = ((each - without).mean((0, 1)) for each in (as_object, fewer))
    np.testing.assert_allclose(noisier, change, rtol=0.3)
