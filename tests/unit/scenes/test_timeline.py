import pytest

from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline


def states(keyframes: str) -> list[FrameState]:
    return timeline(load_scene("near", [f"keyframes=[{keyframes}]"]))


def test_motion_between_keyframes_is_linear():
    found = states(
        "{frame=0, gap_mm=4.0}, {frame=4, gap_mm=0.0, x_mm=1.0, y_mm=-2.0, twist_deg=40.0}, {frame=5, gap_mm=-1.0}"
    )
    assert [state.gap_mm for state in found] == pytest.approx([4, 3, 2, 1, 0, -1])
    assert [state.x_mm for state in found] == pytest.approx([0, 0.25, 0.5, 0.75, 1, 0])
    assert [state.y_mm for state in found] == pytest.approx([0, -0.5, -1, -1.5, -2, 0])
    assert [state.twist_deg for state in found] == pytest.approx([0, 10, 20, 30, 40, 0])


def test_there_is_one_state_a_frame():
    assert len(states("{frame=0}, {frame=7, gap_mm=1.0}, {frame=9}")) == 10


def test_equal_keyframes_hold_equal_states():
    found = states("{frame=0, gap_mm=-1.3, x_mm=0.1}, {frame=7, gap_mm=-1.3, x_mm=0.1}")
    assert set(found) == {found[0]}


def test_object_appears_at_its_keyframe_and_not_before():
    found = states("{frame=0}, {frame=3, gap_mm=5.0, x_mm=2.0}, {frame=4, gap_mm=4.0}")
    assert found[:3] == [UNTOUCHED] * 3
    assert not found[2].has_object
    assert (found[3].gap_mm, found[3].x_mm) == (5.0, 2.0)


def test_object_stays_where_it_was_until_the_keyframe_without_it():
    found = states("{frame=0, gap_mm=5.0, x_mm=2.0, twist_deg=9.0}, {frame=3, x_mm=-4.0}, {frame=4}")
    assert set(found[:3]) == {found[0]}
    assert found[0].gap_mm == 5.0
    assert found[0].x_mm == 2.0
    assert found[3] == UNTOUCHED


def test_flashlight_is_on_from_its_keyframe_to_the_next():
    found = states("{frame=0}, {frame=2, flashlight=true}, {frame=4}, {frame=5}")
    assert [state.flashlight for state in found] == [False, False, True, True, False, False]


def test_flashlight_moves_between_keyframes_that_are_lit():
    found = states(
        "{frame=0, flashlight=true, light_x_mm=-4.0}, "
        "{frame=4, flashlight=true, light_x_mm=4.0}, {frame=6, light_x_mm=9.0}"
    )
    assert [state.light_x_mm for state in found] == pytest.approx([-4, -2, 0, 2, 4, 4, 0])


def test_place_of_a_flashlight_that_is_off_does_not_matter():
    assert states("{frame=0, light_x_mm=3.0}")[0] == UNTOUCHED


def test_place_of_an_absent_object_does_not_matter():
    assert states("{frame=0, x_mm=3.0, twist_deg=5.0}")[0] == UNTOUCHED


def test_single_keyframe_is_a_single_frame():
    assert states("{frame=0, gap_mm=1.0}") == [
        FrameState(gap_mm=1.0, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
    ]
