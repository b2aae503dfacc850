"""Which targets are met together, and what of a sensor is left out."""

from dataclasses import dataclass, field

import numpy as np
from laboratory.operating_point import search
from laboratory.operating_point.filming import LED_GAP_MM, LEDS, search_scene, single_leds
from laboratory.operating_point.front import exclusive, front, met
from laboratory.operating_point.search import CAMERA_NAMES, LEFT_OUT, OPTICAL_NAMES
from laboratory.operating_point.targets import TARGETS

from magicsim.fit.constants import with_values


@dataclass
class Drawn:
    """A camera of which nothing was read."""

    camera: list[float]
    optical: list[float] = field(default_factory=list)


def test_a_target_is_met_within_its_interval():
    middle = {name: max(min(0.5 * (each.low + each.high), 1e3), -1e3) for name, each in TARGETS.items()}
    assert met(middle) == set(TARGETS)
    assert met(middle | {"s_rest": 0.95}) == set(TARGETS) - {"s_rest"}


def test_pairs_exclude_each_other_only_where_both_are_met_by_somebody():
    sensors = [frozenset({"s_rest", "c_far"}), frozenset({"s_near", "c_far"}), frozenset({"c_far"})]
    assert exclusive(sensors) == [("s_rest", "s_near")]


def test_front_holds_the_sets_that_nobody_widens():
    wide, other, narrow = frozenset({"s_rest", "c_far"}), frozenset({"s_near"}), frozenset({"c_far"})
    assert front([narrow, wide, other, wide]) == [(wide, 2), (other, 1)]


def test_single_leds_stand_beside_the_block_and_shine_into_it():
    scene = search_scene(12, 16)
    leds = single_leds(scene)
    assert len(leds) == LEDS * len(scene.rig.strips)
    rig = with_values(scene, {"rig.leds": leds}).rig  # refused where one stands in the block
    for led in rig.leds:
        outside = np.abs(led.place_mm[:2]) - np.array(scene.design.footprint_mm) / 2
        assert outside.max() == LED_GAP_MM
        ahead = np.array(led.place_mm) + 2 * LED_GAP_MM * np.array(led.axis)
        assert (np.abs(ahead[:2]) < np.array(scene.design.footprint_mm) / 2).all()


def test_mechanisms_that_are_left_out_are_constants_of_the_search():
    names = {*OPTICAL_NAMES, *CAMERA_NAMES}
    assert all(set(change) <= names for change in LEFT_OUT.values())


def test_later_rounds_of_a_step_draw_cameras_around_the_best_of_it(monkeypatch):
    monkeypatch.setattr(search, "film_states", lambda scene, fields: None)
    monkeypatch.setattr(search, "candidate", lambda states, scene, optical, camera, profile: Drawn(camera))
    good = [Drawn([0.5] * len(CAMERA_NAMES), [0.5] * len(OPTICAL_NAMES))] * 2
    options = {"aim": lambda each: each.camera[0], "first": 1, "cameras": 8, "seed": 1}
    even = search.search_step(None, None, [], index=0, **options)
    later = search.search_step(None, None, good, index=1, **options)
    assert (len(even), len(later)) == (8, 8 + (search.ROUNDS - 1) * 4)
    assert later == search.search_step(None, None, good, index=1, **options)
    rounds = [np.mean([each.camera[0] for each in later[start : start + 4]]) for start in (8, 8 + 4 * 2)]
    assert rounds[-1] < rounds[0] < np.mean([each.camera[0] for each in later[:8]])
