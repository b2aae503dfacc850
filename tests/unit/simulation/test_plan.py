import re

import pytest

from magicsim.errors import ConfigError
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.plan import UNTOUCHED_FRAME, ScenePlan, plan_scene


def plan(keyframes: str, *settings: str, leave_out: bool = True) -> ScenePlan:
    return plan_scene(load_scene("near", [f"keyframes=[{keyframes}]", *settings]), leave_out=leave_out)


def reasons(decisions: tuple, stage: str) -> list[str]:
    return [decision.reason for decision in decisions if decision.stage == stage]


@pytest.mark.parametrize(("gap_mm", "touches"), [(5.0, False), (0.0, False), (-1e-6, True), (-1.0, True)])
def test_only_an_object_above_the_contact_face_can_touch(gap_mm: float, touches: bool):
    assert timeline(load_scene("near", [f"keyframes=[{{frame=0, gap_mm={gap_mm}}}]"]))[0].can_touch == touches
    assert plan(f"{{frame=0, gap_mm={gap_mm}}}").frames[0].solve == touches


def test_untouched_frames_share_the_radiance_of_the_references():
    planned = plan("{frame=0}, {frame=2, gap_mm=1.0}, {frame=3}, {frame=4}")
    assert [frame.same_as for frame in planned.frames] == [UNTOUCHED_FRAME, UNTOUCHED_FRAME, None, -1, -1]


def test_pose_out_of_contact_is_reused_whenever_it_comes_again():
    planned = plan("{frame=0, gap_mm=2.0}, {frame=1, gap_mm=1.0}, {frame=2, gap_mm=2.0}, {frame=3, gap_mm=1.0}")
    assert [frame.same_as for frame in planned.frames] == [None, None, 0, 1]


def test_pose_held_in_contact_is_solved_once():
    planned = plan("{frame=0, gap_mm=-0.5}, {frame=1, gap_mm=-1.0}, {frame=4, gap_mm=-1.0}")
    assert [frame.same_as for frame in planned.frames] == [None, None, 1, 1, 1]
    assert [frame.solve for frame in planned.frames] == [True, True, False, False, False]


def test_pose_that_comes_again_in_contact_is_solved_again_because_paths_have_a_history():
    planned = plan("{frame=0, gap_mm=-1.0}, {frame=1, gap_mm=-0.5}, {frame=2, gap_mm=-1.0}")
    assert [frame.same_as for frame in planned.frames] == [None, None, None]
    assert all(frame.solve for frame in planned.frames)


def test_hold_after_a_return_reuses_the_return_and_not_the_first_visit():
    planned = plan("{frame=0, gap_mm=-1.0}, {frame=1, gap_mm=-0.5}, {frame=2, gap_mm=-1.0}, {frame=3, gap_mm=-1.0}")
    assert planned.frames[3].same_as == 2


def test_twist_and_shear_are_motions():
    planned = plan("{frame=0, gap_mm=-1.0}, {frame=1, gap_mm=-1.0, x_mm=0.1}, {frame=2, gap_mm=-1.0, twist_deg=1.0}")
    assert [frame.same_as for frame in planned.frames] == [None, None, None]


def test_light_that_goes_on_is_rendered_again_and_then_reused():
    planned = plan("{frame=0}, {frame=1, flashlight=true}, {frame=3}, {frame=4, flashlight=true}")
    assert [frame.same_as for frame in planned.frames] == [-1, None, 1, -1, 1]
    assert not any(frame.solve for frame in planned.frames)


def test_planning_in_full_reuses_nothing_and_solves_every_contact():
    planned = plan("{frame=0}, {frame=1, gap_mm=-1.0}, {frame=3, gap_mm=-1.0}, {frame=4}", leave_out=False)
    assert [frame.same_as for frame in planned.frames] == [None] * 5
    assert [frame.solve for frame in planned.frames] == [False, True, True, True, False]


def test_reuse_points_at_an_earlier_frame_in_the_same_state_that_is_rendered():
    planned = plan_scene(load_scene("demo"))
    for index, frame in enumerate(planned.frames):
        if frame.same_as is not None and frame.same_as != UNTOUCHED_FRAME:
            assert frame.same_as < index
            assert planned.frames[frame.same_as].same_as is None
            assert planned.frames[frame.same_as].state == frame.state


def test_deformation_is_left_out_for_each_reason_with_its_number_of_frames():
    planned = plan("{frame=0}, {frame=2, gap_mm=1.0}, {frame=3, gap_mm=-1.0}, {frame=6, gap_mm=-1.0}")
    assert reasons(planned.kept, "deformation") == ["1 of 7 frames: the object can touch"]
    assert sorted(reasons(planned.left_out, "deformation")) == [
        "1 of 7 frames: the object cannot touch",
        "2 of 7 frames: no object",
        "3 of 7 frames: same pose as the frame before",
    ]


def test_kept_and_left_out_frames_of_a_stage_add_up_to_all():
    planned = plan_scene(load_scene("demo"))
    for stage in ("deformation", "camera pass", "object in the optical scene", "flashlight in the optical scene"):
        counts = [
            int(re.match(r"\d+", reason)[0])
            for reason in reasons(planned.kept, stage) + reasons(planned.left_out, stage)
        ]
        assert sum(counts) == len(planned.frames)


def test_no_light_pass_where_nothing_scatters_and_no_object_is_lit():
    clear = plan("{frame=0, flashlight=true}", "design=uniform-block")
    assert reasons(clear.kept, "light pass") == []
    assert reasons(clear.left_out, "light pass") == ["1 of 1 frames: nothing scatters"]


def test_light_pass_is_kept_where_only_the_body_scatters():
    cloudy = plan("{frame=0, flashlight=true}", "design=uniform-block", "design.materials.body.sigma_s_per_mm=0.2")
    assert reasons(cloudy.kept, "light pass") == ["1 of 1 frames: the light changes"]


def test_light_pass_is_kept_where_an_object_is_lit_through_a_clear_block():
    clear = plan("{frame=0, gap_mm=1.0}", "design=uniform-block")
    assert reasons(clear.kept, "light pass") == ["1 of 1 frames: the light changes"]


def test_flashlight_and_object_are_left_out_of_the_optical_scene_when_absent():
    planned = plan("{frame=0}, {frame=3, flashlight=true}")
    assert reasons(planned.kept, "object in the optical scene") == []
    assert reasons(planned.left_out, "object in the optical scene") == ["4 of 4 frames: no object"]
    assert reasons(planned.kept, "flashlight in the optical scene") == ["1 of 4 frames: the light is on"]
    assert reasons(planned.left_out, "flashlight in the optical scene") == ["3 of 4 frames: the light is off"]


def test_outputs_not_asked_for_are_left_out():
    planned = plan("{frame=0}", "output.contact_mask=false", "output.report=false")
    left_out = {decision.stage for decision in planned.left_out if decision.stage.startswith("output")}
    kept = {decision.stage for decision in planned.kept if decision.stage.startswith("output")}
    assert left_out == {"output contact_mask", "output depth_map", "output taxels", "output mcap", "output report"}
    assert kept == {"output displacements", "output preview"}


def test_reference_frames_are_kept_only_where_there_are_some():
    assert reasons(plan("{frame=0}", "references=12").kept, "reference frames")[0].startswith("12 frames")
    assert reasons(plan("{frame=0}", "references=0").kept, "reference frames") == []


def test_every_decision_gives_a_reason():
    planned = plan_scene(load_scene("demo"))
    assert all(decision.reason for decision in planned.kept + planned.left_out)


def test_efforts_cover_the_stream_and_weigh_what_is_solved_and_rendered_most():
    scene = load_scene("demo")
    planned = plan_scene(scene)
    costs = planned.efforts
    assert len(costs) == scene.references + scene.frame_count
    solved = costs[scene.references + next(n for n, frame in enumerate(planned.frames) if frame.solve)]
    reused = costs[scene.references + next(n for n, frame in enumerate(planned.frames) if frame.same_as is not None)]
    assert costs[0] > solved > 10 * reused > 0


def test_a_lattice_coarser_than_an_objects_edges_is_told():
    stage = "lattice as fine as the object's edges"
    pressed = "keyframes=[{frame=0, gap_mm=-1.0}]"
    flat = 'object={kind="punch", radius_mm=3.0, edge_radius_mm=0.5}'
    even = "design.lattice.edge_nodes=0"
    (reason,) = reasons(plan_scene(load_scene("rest", [flat, pressed, even])).left_out, stage)
    assert "edges of 0.5 mm on cells of up to 1 mm" in reason
    small = 'object={kind="sphere", radius_mm=0.5}'  # gets finer cells by itself
    for fine in ([flat, pressed], [flat, pressed, even, "design.lattice.spacing_mm=0.5"], [pressed, even, small]):
        assert reasons(plan_scene(load_scene("rest", fine)).left_out, stage) == []
    assert reasons(plan_scene(load_scene("rest", [flat, "keyframes=[{frame=0, gap_mm=1.0}]"])).left_out, stage) == []


@pytest.mark.parametrize("pattern", ['kind="dots", radius_mm=0.5', 'kind="lines", width_mm=1.0'])
def test_a_lattice_coarser_than_a_pattern_is_told(pattern):
    stage = "lattice as fine as the object's pattern"
    pressed, fine = "keyframes=[{frame=0, gap_mm=-1.0}]", "design.lattice.spacing_mm=0.5"
    plate = f"object={{{pattern}, spacing_mm=2.0}}"
    (reason,) = reasons(plan_scene(load_scene("rest", [plate, pressed])).left_out, stage)
    assert "2 mm apart on cells of up to 1 mm" in reason
    assert fine.replace("=", " = ") in reason
    smooth = 'object={kind="box", size_mm=[6.0, 6.0, 2.0]}'
    for scene in ([plate, pressed, fine], [plate, "keyframes=[{frame=0, gap_mm=1.0}]"], [smooth, pressed]):
        assert reasons(plan_scene(load_scene("rest", scene)).left_out, stage) == []


def test_long_hold_in_contact_is_planned_in_one_pass():
    planned = plan("{frame=0, gap_mm=-1.0}, {frame=20000, gap_mm=-1.0}")
    assert {frame.same_as for frame in planned.frames[1:]} == {0}


def test_frames_after_a_touch_are_solved_while_a_dent_may_recover():
    keys = "{frame=0, gap_mm=1.0}, {frame=1, gap_mm=-0.5}, {frame=2, gap_mm=1.0}, {frame=3}, {frame=4}"
    prony = "design.materials.body.prony=[{time_s=1.0,modulus_mpa=1.0}]"
    timed = ["contact.rate_dependent=true", prony]
    assert [frame.solve for frame in plan(keys, *timed).frames] == [False, True, False, False, False]
    recovering = plan(keys, *timed, "contact.recovers=true").frames
    assert [frame.solve for frame in recovering] == [False, True, True, True, True]
    assert all(frame.same_as is None for frame in recovering[1:])


def test_a_dent_asks_for_a_body_with_a_memory():
    with pytest.raises(ConfigError, match="recovers = true is not allowed with rate_dependent = false"):
        plan("{frame=0}", "contact.recovers=true")
