import dataclasses
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from magicsim.detectors import DetectorProfile, Proximity, Verdict
from magicsim.detectors.combined import judge
from magicsim.detectors.grasp import GraspStage, GraspState, step_grasp

PROFILE = DetectorProfile(
    tau_g=0.8, approach_frames=3, entropy_hysteresis=0.2, touch_frames=2, touch_hysteresis=0.5, transport_frames=2,
    slip_share=0.25, slip_window=2, close_frames=8, return_frames=2,
)  # fmt: skip


def frame(entropy: float, correlation: float, similarity: float) -> Verdict:
    return judge(entropy=entropy, correlation=correlation, similarity=similarity, profile=PROFILE)


CLEAR, FADED = frame(0.1, 0.0, 0.99), frame(0.4, 0.0, 0.99)
NEAR, TOUCH, LIGHT = frame(2.0, 0.1, 0.95), frame(3.0, 0.1, 0.5), frame(6.0, 0.9, 0.1)
LEAVING = frame(2.0, 0.1, 0.85)  # above tau_g, below the hysteresis

features = st.builds(frame, st.floats(0, 8), st.floats(-1, 1), st.floats(0, 1))
light_frames = st.builds(frame, st.floats(PROFILE.tau_e, 8), st.floats(PROFILE.tau_c, 1), st.floats(0, 1))


def run_grasp(verdicts, profile):
    state = GraspState()
    for verdict in verdicts:
        state = step_grasp(state, verdict, profile)
        yield state


def stages(*verdicts, profile=PROFILE):
    return [state.stage.value for state in run_grasp(verdicts, profile)]


def test_whole_run_goes_through_every_stage_and_waits_again():
    frames = [CLEAR, *[NEAR] * 3, *[TOUCH] * 5, NEAR, NEAR, CLEAR, CLEAR, CLEAR]
    assert stages(*frames) == [
        *["Waiting"] * 3, *["Closing"] * 2, *["Grasped"] * 2, *["Transporting"] * 2, "Slipped", "Returning",
        *["Waiting"] * 3,
    ]  # fmt: skip


def test_light_in_between_ends_the_approach():
    assert stages(NEAR, NEAR, LIGHT, NEAR, NEAR)[-1] == "Waiting"
    assert stages(NEAR, NEAR, LIGHT, NEAR, NEAR, NEAR)[-1] == "Closing"


def test_entropy_just_below_its_threshold_neither_counts_nor_ends_the_approach():
    assert stages(NEAR, NEAR, FADED, NEAR)[-1] == "Closing"
    assert stages(NEAR, NEAR, FADED, FADED)[-1] == "Waiting"
    assert stages(NEAR, NEAR, CLEAR, NEAR)[-1] == "Waiting"


def closed(*more, **options):
    return stages(*[NEAR] * 3, *more, profile=dataclasses.replace(PROFILE, **options))[3:]


def test_touch_must_last_and_hysteresis_bridges_a_weaker_frame():
    assert closed(TOUCH, TOUCH) == ["Closing", "Grasped"]
    assert closed(TOUCH, LEAVING, TOUCH)[-1] == "Grasped"
    assert closed(TOUCH, NEAR, TOUCH)[-1] == "Closing"
    assert closed(TOUCH, LIGHT, TOUCH)[-1] == "Grasped"


def test_closing_on_nothing_returns_after_a_while():
    assert closed(*[CLEAR] * 8) == [*["Closing"] * 7, "Returning"]
    assert closed(*[CLEAR] * 10)[-1] == "Waiting"


def test_touch_in_the_last_frame_of_closing_still_grasps():
    assert closed(*[NEAR] * 6, TOUCH, TOUCH)[-1] == "Grasped"


def test_light_while_holding_is_no_slip_and_no_time():
    held = closed(TOUCH, TOUCH, TOUCH, LIGHT, LIGHT, TOUCH, TOUCH)
    assert held[1:] == [*["Grasped"] * 4, *["Transporting"] * 2]
    assert closed(*[TOUCH] * 4, LIGHT, NEAR, TOUCH)[-1] == "Transporting"


def test_opening_on_purpose_is_no_slip():
    state = GraspState(stage=GraspStage.TRANSPORTING)
    state = step_grasp(state, NEAR, PROFILE, opening=True)
    assert state.stage is GraspStage.RETURNING
    assert step_grasp(state, NEAR, PROFILE, opening=True).run == 1
    assert step_grasp(GraspState(run=2), NEAR, PROFILE, opening=True).stage is GraspStage.CLOSING


def test_return_needs_untouched_frames_in_a_row_that_are_not_light():
    back = GraspState(stage=GraspStage.RETURNING)
    for verdict, run in ((CLEAR, 1), (LIGHT, 1), (TOUCH, 0), (NEAR, 1)):
        back = step_grasp(back, verdict, PROFILE)
        assert (back.stage, back.run) == (GraspStage.RETURNING, run)
    assert step_grasp(back, CLEAR, PROFILE) == GraspState()


def test_slip_is_the_state_of_one_frame_whatever_follows():
    slipped = GraspState(stage=GraspStage.SLIPPED)
    for verdict in (CLEAR, TOUCH, LIGHT):
        assert step_grasp(slipped, verdict, PROFILE).stage is GraspStage.RETURNING


@given(frames=st.lists(light_frames, max_size=40))
def test_light_alone_never_closes(frames):
    assert set(stages(*frames)) <= {"Waiting"}


@given(frames=st.lists(st.one_of(features, st.just(NEAR), light_frames), max_size=60))
def test_gripper_closes_only_after_enough_approach_since_the_last_light(frames):
    seen = stages(*frames)
    for number, (before, after) in enumerate(pairwise(["Waiting", *seen])):
        if (before, after) == ("Waiting", "Closing"):
            assert frames[number].proximity is Proximity.APPROACHING
            since = frames[: number + 1]
            last_light = max((k for k, one in enumerate(since) if one.proximity is Proximity.NOISE), default=-1)
            after_light = [one for one in since[last_light + 1 :] if one.proximity is Proximity.APPROACHING]
            assert len(after_light) >= 3


@given(frames=st.lists(features, max_size=60))
def test_light_triggers_nothing_but_the_end_of_closing(frames):
    before = GraspState()
    for verdict, after in zip(frames, run_grasp(frames, PROFILE), strict=True):
        if verdict.proximity is Proximity.NOISE and after.stage is not before.stage:
            assert (before.stage, after.stage) in {
                (GraspStage.CLOSING, GraspStage.RETURNING),
                (GraspStage.SLIPPED, GraspStage.RETURNING),
            }
        before = after


ALLOWED = {
    "Waiting": {"Closing"},
    "Closing": {"Grasped", "Returning"},
    "Grasped": {"Transporting", "Slipped"},
    "Transporting": {"Slipped"},
    "Slipped": {"Returning"},
    "Returning": {"Waiting"},
}


@given(frames=st.lists(features, max_size=80))
def test_stages_follow_each_other_only_as_drawn(frames):
    seen = ["Waiting", *stages(*frames)]
    for before, after in pairwise(seen):
        assert after == before or after in ALLOWED[before]


@given(frames=st.lists(features, max_size=30))
def test_steps_are_pure(frames):
    assert list(run_grasp(frames, PROFILE)) == list(run_grasp(frames, PROFILE))
