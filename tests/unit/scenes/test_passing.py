"""What passes in a room: where it is follows from seed and time alone, and what cannot be is one line."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.scenes.room import OUT_OF_SIGHT, Passing
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import reference_states, timeline
from magicsim.simulation.plan import UNTOUCHED_FRAME, plan_scene

CORRIDOR = "rig.room='corridor'"


def test_it_crosses_at_its_speed_and_comes_again():
    passing = Passing(every_s=4.0, speed_mm_s=500.0)
    places = [passing.place_mm(time_s, 7) for time_s in np.arange(0, 8, 0.1)]
    steps = np.diff([np.nan if place is None else place for place in places])
    assert abs(np.nanmedian(steps)) == pytest.approx(50)
    assert places[:40] == pytest.approx(places[40:])


def test_seeds_have_times_and_directions_of_their_own():
    passing = Passing(every_s=4.0)
    first = [passing.place_mm(0.0, seed) for seed in range(20)]
    then = [passing.place_mm(0.01, seed) for seed in range(20)]
    assert len(set(first)) == len(first)
    assert {np.sign(b - a) for a, b in zip(first, then, strict=True)} == {-1, 1}


def test_far_beside_it_is_out_of_sight():
    passing = Passing(distance_mm=100.0, speed_mm_s=1000.0, every_s=10.0)
    places = [passing.place_mm(time_s, 1) for time_s in np.arange(0, 10, 0.05)]
    there = [abs(place) for place in places if place is not None]
    assert max(there) < OUT_OF_SIGHT * 100
    assert len(there) / len(places) == pytest.approx(2 * OUT_OF_SIGHT * 100 / 10_000, abs=0.02)


def test_a_corridor_has_somebody_and_an_office_has_nobody():
    corridor, office = (load_scene("demo", [f"rig.room='{room}'"]) for room in ("corridor", "office"))
    assert corridor.rig.moving == Passing()
    assert office.rig.moving is None
    assert {state.passing_mm for state in timeline(office)} == {None}
    places = [state.passing_mm for state in (*reference_states(corridor), *timeline(corridor))]
    due = [corridor.rig.moving.place_mm(number / 15, corridor.seed) for number in range(len(places))]
    assert places == due
    assert len(set(places)) > 10


def test_frames_without_it_are_still_those_of_the_references():
    still, moved = (plan_scene(load_scene("rest", [CORRIDOR, *more])) for more in (["rig.passing.every_s=3600"], []))
    assert all(frame.same_as == UNTOUCHED_FRAME for frame in still.frames)
    assert any(frame.same_as is None for frame in moved.frames)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("rest", ("rig=digit-rgb", "rig.passing={}"), "passing is not allowed in a dark room"),
        ("rest", (CORRIDOR, "render.estimator=path"), "without recorded light"),
        ("near", ("rig.passing.distance_mm=60", "keyframes=[{frame=0,gap_mm=80}]"), "outside of the room"),
        ("rest", ("rig.passing.speed_mm_s=0",), r"rig\.passing\.speed_mm_s"),
    ],
)
def test_what_cannot_be_is_one_line(name, settings, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_scene(name, list(settings))
    assert "\n" not in str(told.value)
