"""Anchored frames: unbiased, and still where nothing changed."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.camera.exposure import expose, meter
from magicsim.detectors import detect, fuse, load_profile
from magicsim.light.records.untouched import UntouchedStates
from magicsim.light.renderer import Renderer
from magicsim.light.world.finish import Finish
from magicsim.scenes.timeline import View, timeline
from magicsim.simulation.sensor import Sensor

ANCHOR = ("render.anchor_samples=16", "render.anchor_particles=60000")
MANY = ("render.anchor_samples=32", "render.anchor_particles=200000", "render.particles=200000", "render.samples=32")


def test_untouched_sensor_looks_the_same_with_any_seed(small_scene):
    images = [Sensor.for_scene(small_scene("rest", *ANCHOR, seed=seed)).renderer.radiance(View()) for seed in (1, 2)]
    np.testing.assert_allclose(images[0], images[1], atol=1e-6)


@pytest.mark.parametrize("name", ["near", pytest.param("flashlight", marks=pytest.mark.slow)])
def test_anchor_changes_no_mean(small_scene, name):
    narrow = ("design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.rows=56", "object.radius_mm=3")
    scene = small_scene(name, *MANY, *narrow)
    sensor = Sensor.for_scene(scene)
    view = sensor.view(timeline(scene)[0], sensor.rest)
    anchored, plain = sensor.renderer.radiance(view), sensor.renderer.plain_radiance(view)
    np.testing.assert_allclose(anchored.mean((0, 1)), plain.mean((0, 1)), rtol=0.02)


def blocks(image):
    return image.reshape(8, 8, 6, 8, 3).mean((1, 3))


@pytest.mark.slow
def test_anchor_changes_no_mean_of_a_pressed_frame(small_scene):
    # Blocks of 8 x 8 pixels differ by 2.7 % rms, of which noise explains 1.9 %; the filter of details adds nothing.
    found = []
    for seed in (1, 2):
        scene = small_scene("pressed", *MANY, seed=seed)
        sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
        view = sensor.view(state, sensor.deform(state, sensor.rest))
        found.append([sensor.renderer.radiance(view), sensor.renderer.plain_radiance(view, turn=10 + seed)])
    anchored, plain = np.mean(found, 0)
    np.testing.assert_allclose(anchored.mean((0, 1)), plain.mean((0, 1)), rtol=0.01)
    assert np.sqrt(((blocks(anchored) / blocks(plain) - 1) ** 2).mean()) < 0.03


def test_light_of_a_squeezed_scattering_body_is_carried_over_per_volume(small_scene):
    # Carried over as what its voxels hold, the image would be 8 % darker.
    hazy = (
        "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28",
        "object.radius_mm=3", "design.materials.body.sigma_s_per_mm=0.6", "design.materials.infill.sigma_s_per_mm=0",
        "design.lattice.spacing_mm=1", "design.lattice.cells_across=0", *ANCHOR, "render.particles=60000",
    )  # fmt: skip
    scene = small_scene("pressed", *hazy)
    sensor, state = Sensor.for_scene(scene), replace(timeline(scene)[0], gap_mm=-2.5)
    view = sensor.view(state, sensor.deform(state, sensor.rest))
    plain = np.mean([sensor.renderer.plain_radiance(view, turn=turn) for turn in (1, 2)], 0)
    np.testing.assert_allclose(sensor.renderer.radiance(view).mean(), plain.mean(), rtol=0.025)


def test_preparations_change_no_frame(small_scene):
    scene = small_scene("near", "render.anchor_samples=4", "render.anchor_particles=20000", "render.particles=2000")
    bare, prepared = Sensor.for_scene(scene), Sensor.for_scene(scene)
    view = prepared.view(timeline(scene)[0], prepared.rest)
    prepared.renderer.warm_up(view)
    prepared.renderer.prepare(view)
    np.testing.assert_array_equal(prepared.renderer.radiance(view), bare.renderer.radiance(view))


def test_frames_with_an_object_and_a_flashlight_add_what_each_brings(small_scene):
    # A small ball far in front of the face: it hides little of the flashlight, and adds its own light.
    scene = small_scene("near", *ANCHOR, "object.radius_mm=1")
    sensor = Sensor.for_scene(scene)
    alone = sensor.view(timeline(scene)[0], sensor.rest)
    both = View(indenter=alone.indenter, flashlight_x_mm=0.0)
    rest, near, lamp, together = (
        sensor.renderer.radiance(view) for view in (View(), alone, View(flashlight_x_mm=0.0), both)
    )
    added = (near - rest) + (lamp - rest)
    assert (together - rest).mean() == pytest.approx(added.mean(), rel=0.1)
    # Behind the ball no lamp is seen: the middle of the image is darker than the sum.
    middle = (slice(28, 36), slice(20, 28))
    assert (together - rest)[middle].mean() < 0.8 * added[middle].mean()


def test_empty_scene_stays_normal_against_references_of_another_seed(small_scene):
    profile = load_profile("calibrated")
    first, second = small_scene("rest", *ANCHOR, seed=1), small_scene("rest", *ANCHOR, seed=2)
    untouched, other = (Sensor.for_scene(scene).renderer.radiance(View()) for scene in (first, second))
    camera = first.rig.camera
    exposure = meter(untouched, camera)
    frames = [expose(untouched, exposure, camera, seed=1, frame=index) for index in range(30)]
    verdict = detect(expose(other, exposure, camera, seed=2, frame=40), fuse(frames, profile), profile)
    assert verdict.proximity == "Normal"


def test_ghost_changes_the_sampling_and_not_the_verdict(small_scene):
    # An object that light passes as if nothing were there: paths differ, light does not.
    scene = small_scene("near", *MANY, "render.samples=6", "render.particles=80000")
    sensor = Sensor.for_scene(scene)
    renderer = Renderer(
        sensor.elastomer,
        scene.rig,
        scene.render,
        seed=scene.seed,
        object_mesh=sensor.renderer.object_mesh,
        object_finish=Finish(is_ghost=True),
    )
    renderer.leaves_out_unmoved = False  # all paths anew, or nothing would change
    untouched = renderer.radiance(View())
    ghost = renderer.radiance(sensor.view(timeline(scene)[0], sensor.rest))
    assert (ghost != untouched).any()
    assert np.sqrt(((ghost - untouched) ** 2).mean()) < 0.02 * untouched.mean()
    profile, camera, exposure = load_profile("calibrated"), scene.rig.camera, meter(untouched, scene.rig.camera)
    references = fuse([expose(untouched, exposure, camera, seed=1, frame=index) for index in range(30)], profile)
    verdicts = [
        detect(expose(image, exposure, camera, seed=2, frame=40), references, profile) for image in (untouched, ghost)
    ]
    assert [verdict.proximity for verdict in verdicts] == ["Normal", "Normal"]
    assert verdicts[1].entropy < verdicts[0].entropy + 0.3


QUICK = (
    "render.anchor_samples=4", "render.anchor_particles=5000", "render.particles=5000", "render.samples=2",
    "design.lattice.spacing_mm=2", "design.lattice.cells_across=0", "design.footprint_mm=[8,9]",
    "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28", "object.radius_mm=3",
)  # fmt: skip


def test_sensor_with_other_random_numbers_is_that_of_a_scene_with_these(small_scene):
    scene = small_scene("pressed", *QUICK, seed=1)
    first, state = Sensor.for_scene(scene), timeline(scene)[0]
    second = first.reseeded(2)
    view = first.view(state, first.deform(state, first.rest))
    shown = [each.renderer.radiance(view) for each in (first, second, first)]
    other = Sensor.for_scene(
        small_scene("pressed", *QUICK, f"render.anchor_seed={scene.render.anchor_seed + 2}", seed=3)
    )
    np.testing.assert_array_equal(shown[1], other.renderer.radiance(view))
    np.testing.assert_array_equal(shown[2], shown[0])
    assert np.abs(shown[1] - shown[0]).max() > 0
    assert (second.seed, first.seed) == (3, 1)


def test_sensors_of_one_seed_share_what_their_frames_refer_to_and_of_another_do_not(small_scene):
    states = UntouchedStates()

    def anchor(*changes: str, seed: int = 1):
        sensor = Sensor.for_scene(small_scene("near", *QUICK, *changes, seed=seed), untouched=states)
        return sensor.renderer.control()

    first = anchor()
    assert anchor("object.radius_mm=2.0", "rig.camera.region_px=[8,8,16,16]") is first
    for changed in ("render.samples=4", "render.particles=6000"):
        assert anchor(changed) is not anchor()
    assert anchor(seed=2) is not anchor()
