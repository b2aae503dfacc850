from dataclasses import replace
from itertools import pairwise
from math import hypot
from types import SimpleNamespace

import pytest

from magicsim.geometry.objects.kinds import parse_object
from magicsim.robot.workspace import ENTRY_STEP_MM, SLIDE_STEP_MM, travel, waypoints
from magicsim.scenes.timeline import UNTOUCHED

NEAR = replace(UNTOUCHED, gap_mm=1.0)
PRESSED = replace(UNTOUCHED, gap_mm=-1.0)


def test_way_that_ends_without_contact_is_not_solved():
    assert waypoints(PRESSED, NEAR, has_friction=True, reach_mm=2) == []
    assert waypoints(PRESSED, UNTOUCHED, has_friction=True, reach_mm=2) == []


def test_without_friction_only_the_end_counts():
    far = replace(PRESSED, x_mm=4.0, twist_deg=80.0)
    assert waypoints(PRESSED, far, has_friction=False, reach_mm=2) == [far]


def test_straight_press_is_left_to_the_solver():
    assert waypoints(NEAR, PRESSED, has_friction=True, reach_mm=2) == [PRESSED]
    assert waypoints(UNTOUCHED, PRESSED, has_friction=True, reach_mm=2) == [PRESSED]


def test_oblique_entry_is_followed_from_first_contact():
    end = replace(PRESSED, x_mm=2.0)
    way = waypoints(NEAR, end, has_friction=True, reach_mm=2)
    assert way[-1] == end
    assert way[0].gap_mm < 0
    assert way[0].x_mm == pytest.approx(1 - way[0].gap_mm)  # half way along, where the gap closes
    start = replace(way[0], gap_mm=0.0, x_mm=1.0)
    assert all(hypot(b.x_mm - a.x_mm, b.gap_mm - a.gap_mm) <= ENTRY_STEP_MM + 1e-9 for a, b in pairwise([start, *way]))


def test_slide_is_cut_into_steps_that_overlap():
    end = replace(PRESSED, x_mm=3.0, y_mm=-4.0)
    way = waypoints(PRESSED, end, has_friction=True, reach_mm=2)
    assert way[-1] == end
    assert len(way) == 5 / SLIDE_STEP_MM


def test_twist_counts_by_the_way_of_the_rim():
    turned = replace(PRESSED, twist_deg=90.0)
    assert len(waypoints(PRESSED, turned, has_friction=True, reach_mm=2)) == 7  # pi mm of arc


def test_lights_are_those_of_the_end_all_along():
    end = replace(PRESSED, x_mm=2.0, flashlight=True, light_x_mm=3.0)
    assert all(each.flashlight and each.light_x_mm == 3 for each in waypoints(NEAR, end, has_friction=True, reach_mm=2))


@pytest.mark.parametrize("line", ["box:size_mm=8x8x30", "box:size_mm=30x8x8,pitch_deg=-90"])
def test_tilt_counts_by_the_height_of_the_object_as_it_stands(line: str):
    solved = []

    def deform(state, previous):
        solved.append(state)
        return previous

    rest = SimpleNamespace(is_rest=True)
    sensor = SimpleNamespace(
        contact=SimpleNamespace(friction=0.8), lattice=SimpleNamespace(zone=None), object=parse_object(line),
        deform=deform, rest=rest,
    )  # fmt: skip
    travel(sensor, PRESSED, replace(PRESSED, tilt_x_deg=20.0), rest, None)
    assert len(solved) == 11  # 15 mm x 20 degrees in steps of 0.5 mm
