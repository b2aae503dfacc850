import pytest

from magicsim.errors import RenderError
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.still import STILL_SAMPLES, render, with_care
from magicsim.simulation.stream import simulate
from magicsim.waiting import unheard


def test_a_still_has_more_samples_and_the_particles_of_the_anchor_where_nothing_else_is_asked_for():
    scene = load_scene("rest")
    both = with_care(scene, samples=True, particles=True).render
    assert (both.samples, both.particles) == (STILL_SAMPLES, scene.render.anchor_particles)
    assert both.samples > scene.render.samples


def test_what_was_asked_for_stays():
    scene = load_scene("rest", ["render.samples=3", "render.particles=700"])
    assert with_care(scene, samples=False, particles=False).render == scene.render
    half = with_care(scene, samples=False, particles=True).render
    assert (half.samples, half.particles) == (3, scene.render.anchor_particles)


def test_care_never_lowers_a_setting():
    scene = load_scene("rest", ["render.samples=90", "render.anchor_samples=0"])
    assert with_care(scene, samples=True, particles=False).render.samples == 90


@pytest.mark.slow
def test_exposure_that_never_settles_is_refused_as_by_simulate_and_told_by_plan():
    scene = load_scene("rest", [
        "rig.camera.columns=12", "rig.camera.rows=16", "rig.camera.exposure_grey=254", "render.samples=1",
        "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=20000",
        "rig.camera.live={gain_limits=[1.0,1.0]}",
    ])  # fmt: skip
    said = []
    for run in (render, simulate):
        with pytest.raises(RenderError, match="live exposure never settles on the untouched sensor") as error:
            run(scene, told=unheard)
        said.append(str(error.value))
    assert said[0] == said[1]
    assert any("never settles" in each.reason for each in plan_scene(scene).kept)
