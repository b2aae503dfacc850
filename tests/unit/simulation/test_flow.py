"""An infill that flows in a scene: forces, heat and dent of `press`, rows that say so, and what it cannot be."""

import numpy as np
import pytest

from magicsim import load_design, load_object, press
from magicsim.dataset.columns import columns_of
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.deform.solve.path import RAISED_MM
from magicsim.errors import ConfigError
from magicsim.robot import LiveSensor
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import Origin, timeline
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import stream_states

YIELD = "contact.infill_yield_mpa=0.001"
BLOCK = ["footprint_mm=[10,10]", "lattice.spacing_mm=2.5", "lattice.cells_across=0"]
SMALL = [f"design.{each}" for each in BLOCK]
PATH = "keyframes=[{frame=0,gap_mm=-0.2},{frame=1,gap_mm=-0.4},{frame=2,gap_mm=2.0},{frame=3},{frame=4,gap_mm=-0.4}]"


def scene_of(*settings):
    return load_scene("pressed", ["object={kind='sphere',radius_mm=4}", PATH, *SMALL, *settings])


def test_a_scene_presses_as_press_does_heats_up_and_keeps_a_dent():
    sensor = Sensor.for_scene(scene_of(YIELD))
    states, deformation = [], sensor.rest
    for state in timeline(scene_of(YIELD)):
        deformation = sensor.deform(state, deformation)
        states.append(deformation)
    found = press(load_design("mini-magictac", BLOCK), load_object("sphere:radius_mm=4"), depth_mm=0.4,
                  infill_yield_mpa=0.001)  # fmt: skip
    assert states[1].force_n[2] == pytest.approx(found.force_n[2], rel=5e-3)
    heat = [each.core.dissipated_nmm for each in states]
    assert heat == sorted(heat)
    assert heat[1] == pytest.approx(found.history[-1].dissipated_nmm, rel=0.05)
    for left in states[2:4]:
        assert not left.force_n.any()
        assert 1e-4 < np.abs(left.displacements_mm).max() < 0.1
    assert 0 < states[1].force_n[2] - states[4].force_n[2] < 0.05 * states[1].force_n[2]
    view = sensor.view(timeline(scene_of(YIELD))[3], states[3])
    assert view.is_released
    assert view.body is not None


def test_columns_and_plan_say_so():
    names = [[each.name for each in columns_of(load_recipe("touches", settings))] for settings in ([YIELD], [])]
    assert set(names[0]) - set(names[1]) == {"dissipated_nmm"}
    scene = scene_of(YIELD)
    planned = plan_scene(scene)
    assert [frame.solve for frame in planned.frames] == [True] * 5
    assert [each.stage for each in planned.kept if each.stage.startswith("flow")] == ["flow of the infill"]
    assert "flow of the infill" in [each.stage for each in plan_scene(scene_of()).left_out]


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ([YIELD, "contact.rate_dependent=true", "design=mini-magictac-rate"], "not allowed with rate_dependent"),
        ([YIELD, "design=uniform-block"], "contact.infill_yield_mpa = 0.001 is not allowed for a block without infill"),
        (["contact.infill_yield_mpa=0"], "contact.infill_yield_mpa = 0"),
    ],
)
def test_what_cannot_flow_is_refused(settings, named):
    with pytest.raises(ConfigError) as error:
        load_scene("pressed", settings)
    assert named in str(error.value)


def test_a_live_sensor_refuses_it():
    with pytest.raises(ConfigError, match=r"infill_yield_mpa = 0\.001 is not allowed here"):
        LiveSensor(scene_of(YIELD))


def solved(keyframes, *, leave_out=True):
    """Deformations of an episode's frames, none of which is rendered."""
    scene = scene_of(YIELD, f"keyframes=[{keyframes}]")
    sensor, plan = Sensor.for_scene(scene), plan_scene(scene, leave_out=leave_out)
    nothing = np.zeros((1, 1, 3), np.float32)
    sensor.render = lambda _state, _deformation: (nothing, Origin())
    states = list(stream_states(sensor, plan, (nothing, Origin())))
    return [each.deformation for each in states if not each.is_reference]


def test_a_frame_that_is_held_after_a_touch_keeps_the_dent_and_what_follows():
    path = "{frame=0,gap_mm=-0.4},{frame=1,gap_mm=1.0},{frame=2,gap_mm=1.0},{frame=3,gap_mm=-0.2}"
    lean, whole = solved(path), solved(path, leave_out=False)
    np.testing.assert_array_equal(lean[2].displacements_mm, lean[1].displacements_mm)
    assert lean[2].core.dissipated_nmm == lean[1].core.dissipated_nmm > 0
    assert lean[3].force_n[2] == pytest.approx(whole[3].force_n[2], rel=1e-3)  # 2 % less than on a virgin block


def test_an_object_that_is_taken_away_is_lifted_where_it_was():
    lifted = solved(f"{{frame=0,gap_mm=-0.4,x_mm=2.0}},{{frame=1,gap_mm={RAISED_MM},x_mm=2.0}}")
    removed = solved("{frame=0,gap_mm=-0.4,x_mm=2.0},{frame=1}")
    assert removed[1].core.dissipated_nmm > removed[0].core.dissipated_nmm
    assert removed[1].core.dissipated_nmm == pytest.approx(lifted[1].core.dissipated_nmm, rel=1e-3)
    np.testing.assert_allclose(removed[1].displacements_mm, lifted[1].displacements_mm, atol=1e-6)
