"""Anchored frames: unbiased, and still where nothing changed."""

import numpy as np

from magicsim.detectors import detect, fuse, load_profile
from magicsim.scenes.exposure import expose, meter
from magicsim.scenes.finish import Finish
from magicsim.scenes.timeline import timeline
from magicsim.scenes.view import View
from magicsim.simulation import Sensor

ANCHOR = ("render.anchor_samples=32", "render.anchor_particles=200000")


def test_untouched_sensor_looks_the_same_with_any_seed(small_scene):
    images = [Sensor(small_scene("rest", *ANCHOR, seed=seed)).renderer.radiance(View()) for seed in (1, 2)]
    np.testing.assert_allclose(images[0], images[1], atol=1e-6)


def test_anchor_changes_no_mean(small_scene):
    scene = small_scene("near", *ANCHOR, "render.particles=200000", "render.samples=32")
    sensor = Sensor(scene)
    view = sensor.view(timeline(scene)[0], sensor.rest)
    anchored, plain = sensor.renderer.radiance(view), sensor.renderer.plain_radiance(view)
    np.testing.assert_allclose(anchored.mean((0, 1)), plain.mean((0, 1)), rtol=0.02)


def test_empty_scene_stays_normal_against_references_of_another_seed(small_scene):
    profile = load_profile("calibrated")
    first, second = small_scene("rest", *ANCHOR, seed=1), small_scene("rest", *ANCHOR, seed=2)
    untouched, other = (Sensor(scene).renderer.radiance(View()) for scene in (first, second))
    camera = first.rig.camera
    exposure = meter(untouched, camera)
    frames = [expose(untouched, exposure, camera, seed=1, frame=index) for index in range(30)]
    verdict = detect(expose(other, exposure, camera, seed=2, frame=40), fuse(frames, profile), profile)
    assert verdict.proximity == "Normal"


def test_ghost_changes_the_sampling_and_not_the_verdict(small_scene):
    # An object that light passes as if nothing were there: paths differ, light does not.
    scene = small_scene("near", *ANCHOR, "render.samples=6", "render.particles=80000")
    sensor = Sensor(scene)
    sensor.renderer.object_finish = Finish(is_ghost=True)
    untouched = sensor.renderer.radiance(View())
    ghost = sensor.renderer.radiance(sensor.view(timeline(scene)[0], sensor.rest))
    assert (ghost != untouched).any()
    assert np.sqrt(((ghost - untouched) ** 2).mean()) < 0.02 * untouched.mean()
    profile, camera, exposure = load_profile("calibrated"), scene.rig.camera, meter(untouched, scene.rig.camera)
    references = fuse([expose(untouched, exposure, camera, seed=1, frame=index) for index in range(30)], profile)
    verdicts = [
        detect(expose(image, exposure, camera, seed=2, frame=40), references, profile) for image in (untouched, ghost)
    ]
    assert [verdict.proximity for verdict in verdicts] == ["Normal", "Normal"]
    assert verdicts[1].entropy < verdicts[0].entropy + 0.3
