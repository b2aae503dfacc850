import numpy as np
import pytest

from magicsim.errors import ConfigError, RenderError
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
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


SMALL = (
    "design.footprint_mm=[10,10]", "design.lattice.spacing_mm=2.5", "design.lattice.cells_across=0",
    "rig.camera.columns=12", "rig.camera.rows=16", "rig.camera.field_mm=8", "render.samples=1", "render.particles=1000",
    "render.anchor_samples=2", "render.anchor_particles=2000", "references=0",
)  # fmt: skip


@pytest.mark.parametrize("way", ["contact.friction=0.8", "contact.infill_yield_mpa=0.001"])
def test_a_frame_that_depends_on_its_way_is_that_of_the_scene(way, monkeypatch):
    path = "keyframes=[{frame=0,gap_mm=-0.4},{frame=2,gap_mm=-0.4,x_mm=0.6},{frame=3,gap_mm=0.5,x_mm=0.6}]"
    scene = load_scene("pressed", ["object={kind='sphere',radius_mm=4}", path, way, *SMALL])
    seen, view = [], Sensor.view
    monkeypatch.setattr(Sensor, "view", lambda self, state, found: seen.append(found) or view(self, state, found))
    frame = 2 if "friction" in way else 3
    render(scene, frame, told=unheard)
    sensor, deformation = Sensor.for_scene(scene), None
    for each in plan_scene(scene).frames[: frame + 1]:
        deformation = sensor.deform(each.state, deformation or sensor.rest)
    np.testing.assert_allclose(seen[-1].force_n, deformation.force_n, atol=1e-9)
    np.testing.assert_allclose(seen[-1].displacements_mm, deformation.displacements_mm, atol=1e-9)
    assert (abs(deformation.force_n[0]) > 0.01) == ("friction" in way)


def test_a_still_of_a_room_in_which_something_passes_is_refused():
    passing = ["rig.room='corridor'", "frames_per_second=2", "keyframes=[{frame=0,gap_mm=20.0},{frame=2,gap_mm=20.0}]"]
    with pytest.raises(ConfigError, match="a still shows nothing that passes"):
        render(load_scene("near", [*passing, "references=0"]), 1, told=unheard)
