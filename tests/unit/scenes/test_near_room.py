"""What does not fit into a near room is one line, and the untouched sensor of another distance is another one."""

import pytest

from magicsim.errors import ConfigError, RenderError
from magicsim.light.backend import VARIANT
from magicsim.light.records.untouched import untouched_key
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor

SMALL = ("design.footprint_mm=[6,7]", "rig.camera.columns=8", "rig.camera.rows=8", "rig.camera.field_mm=5")


def keyframes(*settings):
    return "keyframes=[{frame=0," + ",".join(settings) + "}]"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("rig.room_distance_mm=30",), "outside of the room would be the housing of the sensor, which reaches 4"),
        (("rig.room_distance_mm=60", keyframes("gap_mm=60")), r"keyframes\.0\.gap_mm = 60 .* outside of the room"),
        (("rig.room_distance_mm=60", keyframes("flashlight=true", "light_x_mm=50")), "would be the flashlight"),
        (("rig.room_distance_mm=60", "rig.room='corridor'"), "where something passes in the room"),
        (("rig.room_distance_mm=1",), r"rig\.room_distance_mm = 1 is not allowed"),
        (
            ("rig.room_distance_mm=60", "rig.leds=[{place_mm=[0,0,-70],direction=[0,0,1],radiance=[1,1,1]}]"),
            r"would be rig\.leds\.0, which reaches 70\.5 mm",
        ),
    ],
)
def test_what_does_not_fit_is_one_line(settings, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_scene("near", list(settings))
    assert "\n" not in str(told.value)


def test_an_object_that_reaches_out_of_the_room_is_refused_by_the_plan():
    scene = load_scene("near", ["rig.room_distance_mm=60", keyframes("gap_mm=55")])
    with pytest.raises(ConfigError, match=r"keyframe 0: .* would be the object, which reaches 6"):
        plan_scene(scene)


@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_an_object_that_was_moved_out_of_the_room_is_not_rendered():
    sensor = Sensor.for_scene(load_scene("near", [*SMALL, "rig.room_distance_mm=60", keyframes("gap_mm=2")]))
    state = FrameState(gap_mm=58.0, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
    with pytest.raises(RenderError, match="outside of the room would be the object"):
        sensor.renderer.world(sensor.view(state, sensor.rest))


def test_a_dark_room_has_no_distance_and_a_plan_names_that_of_a_lit_one():
    dark = load_scene("near", ["rig.room_distance_mm=30", "rig.room=dark"])
    assert dark.rig.near_mm is None
    lit = load_scene("near", ["rig.room_distance_mm=150"])
    assert [each.reason[:21] for each in plan_scene(lit).kept if each.stage == "near room"] == ["its picture is 150 mm"]
    assert not [each for each in plan_scene(dark).kept if each.stage == "near room"]


def test_records_are_those_of_one_distance():
    scenes = [load_scene("near", [f"rig.room_distance_mm={each}"]) for each in (100, 101)]
    scenes += [
        load_scene("near", more) for more in ([], ["rig.room_distance_mm=100", "rig.room=dark"], ["rig.room=dark"])
    ]
    near, further, infinite, dark, as_dark = (untouched_key(each.design, each.rig, each.render) for each in scenes)
    assert len({near, further, infinite, dark}) == 4
    assert dark == as_dark
