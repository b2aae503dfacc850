from magicsim.scenes.scene import load_scene
from magicsim.simulation.still import with_care


def test_a_still_is_as_careful_as_the_anchor_where_nothing_else_is_asked_for():
    scene = load_scene("rest")
    both = with_care(scene, samples=True, particles=True).render
    assert (both.samples, both.particles) == (scene.render.anchor_samples, scene.render.anchor_particles)
    assert both.samples > scene.render.samples


def test_what_was_asked_for_stays():
    scene = load_scene("rest", ["render.samples=3", "render.particles=700"])
    assert with_care(scene, samples=False, particles=False).render == scene.render
    half = with_care(scene, samples=False, particles=True).render
    assert (half.samples, half.particles) == (3, scene.render.anchor_particles)


def test_care_never_lowers_a_setting():
    scene = load_scene("rest", ["render.samples=90", "render.anchor_samples=0"])
    assert with_care(scene, samples=True, particles=False).render.samples == 90
