"""Drawn see-through sensors: the same each time, fit and test apart, every state in each story."""

from laboratory.see_through.sensors import OBJECTS, draw_sensors

from magicsim.frame_class import FrameClass, classify_frame
from magicsim.scenes.timeline import timeline


def test_longer_list_begins_with_a_shorter_one():
    assert draw_sensors("training", 4) == draw_sensors("training", 6)[:4]


def test_fit_and_test_share_no_object_and_no_sensor():
    assert not {each[0] for each in OBJECTS["training"]} & {each[0] for each in OBJECTS["test"]}
    training, test = draw_sensors("training", 6), draw_sensors("test", 6)
    assert not {each.scene.design.core_mm for each in training} & {each.scene.design.core_mm for each in test}
    assert {each.scene.seed for each in training}.isdisjoint(each.scene.seed for each in test)


def test_lights_alternate_and_outshine_the_room_when_they_are_bright():
    for each in draw_sensors("test", 4):
        led, room = each.scene.rig.strips[0].radiance[0], each.scene.rig.ambient[0]
        assert (led / room > 7) == (each.lights == "bright")


def test_every_story_has_every_class():
    for each in draw_sensors("training", 2):
        states = timeline(each.scene)
        classes = {
            classify_frame(gap_mm=one.gap_mm, force_n=1.0 if (one.gap_mm or 0) < 0 else 0.0, light_on=one.flashlight)
            for one in states
        }
        assert classes >= set(FrameClass)
