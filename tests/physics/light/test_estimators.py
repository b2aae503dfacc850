"""The cached-fluence estimator against Mitsuba's volumetric path tracer, an independent code."""

import numpy as np
import pytest

from magicsim.scenes.timeline import View, timeline
from magicsim.simulation.sensor import Sensor

AGREEMENT = 0.01
BLOCK = ("design.footprint_mm=[8,9]", "rig.camera.field_mm=7")


def channel_means(scene, seeds):
    """Mean radiance of each channel and its standard error over independent seeds."""
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if state.can_touch else sensor.rest
    view = sensor.view(state, deformation)
    means = []
    for seed in seeds:
        sensor.renderer.seed = seed
        means.append(sensor.renderer.plain_radiance(view).mean((0, 1), dtype=np.float64))
    return np.mean(means, 0), np.std(means, 0, ddof=1) / np.sqrt(len(means))


@pytest.mark.parametrize("name", ["rest", pytest.param("pressed", marks=pytest.mark.slow)])
def test_fluence_agrees_with_path_tracing_in_mean_radiance(name, small_scene):
    fluence, error = channel_means(small_scene(name, *BLOCK, "render.particles=50000", "render.samples=8"), range(5))
    path, path_error = channel_means(
        small_scene(name, *BLOCK, "render.estimator=path", "render.samples=16"), range(100, 105)
    )
    difference = np.abs(fluence / path - 1)
    noise = np.hypot(error / fluence, path_error / path)
    assert noise.max() < AGREEMENT, "too noisy to tell anything"
    assert (difference < AGREEMENT + 2 * noise).all(), f"differ by {difference}, standard error {noise}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rest", "near", "pressed"])
def test_fluence_agrees_with_path_tracing_within_one_percent(name, small_scene):
    fluence, error = channel_means(small_scene(name, "render.particles=600000", "render.samples=64"), range(6))
    path, path_error = channel_means(small_scene(name, "render.estimator=path", "render.samples=1024"), range(100, 108))
    noise = np.hypot(error / fluence, path_error / path)
    assert noise.max() < AGREEMENT / 3
    assert (np.abs(fluence / path - 1) < AGREEMENT).all()


def test_mi_render_runs_the_fluence_estimator(small_scene):
    from magicsim.light.backend import mi
    from magicsim.light.transport.integrator import FluenceIntegrator

    scene = small_scene("rest", "rig.camera.blur_px=0", seed=7)
    renderer = Sensor.for_scene(scene).renderer
    expected = renderer.plain_radiance(View())
    light = renderer.light(View())
    integrator = FluenceIntegrator(light, particles=scene.render.particles)
    image = np.array(mi.render(light.scene, integrator=integrator, spp=scene.render.samples, seed=7))
    np.testing.assert_array_equal(image, expected)
