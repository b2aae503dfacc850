"""What passes in the room moves with the frames of a live sensor, as it does in an episode."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from magicsim.robot.live import LiveSensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import Keyframe, SceneConfig, load_scene
from magicsim.simulation.stream import simulate

from .conftest import TINY

CORRIDOR = [
    *TINY, "rig.room='corridor'", "rig.ambient=[0.4,0.4,0.4]", "frames_per_second=4", "references=3", "seed=2",
]  # fmt: skip
SPACE = Workspace(x_mm=(-1, 1), y_mm=(-1, 1), twist_deg=(0, 0), gap_mm=(-1, 5))


@pytest.fixture(scope="module")
def scene() -> SceneConfig:
    return load_scene("pressed", CORRIDOR)


@pytest.fixture(scope="module")
def shared(scene: SceneConfig) -> Iterator[LiveSensor]:
    with LiveSensor(scene, workspace=SPACE, told=lambda _: None) as live:
        yield live


@pytest.fixture
def live(shared: LiveSensor) -> LiveSensor:
    shared.reset()
    return shared


def test_frames_of_a_stream_are_those_of_an_episode(live: LiveSensor, scene: SceneConfig):
    episode = simulate(scene.model_copy(update={"keyframes": (Keyframe(frame=0),)}))
    assert len(episode.frames) == 4
    for due in episode.frames:
        frame = live.frame()
        assert frame.truth.state == due.truth.state
        assert frame.truth.state.passing_mm is not None
        assert (frame.image == due.image).all()


def test_it_moves_by_the_streams_time_and_repeats_by_its_seed(live: LiveSensor):
    def places(seed: int) -> list[float | None]:
        live.reset(seed=seed)
        return [live.grab().state.passing_mm for _ in range(3)]

    first = places(7)
    assert np.diff(first) == pytest.approx([np.diff(first)[0]] * 2)
    assert abs(np.diff(first)[0]) == pytest.approx(250)  # 1000 mm/s, 4 frames a second
    assert places(7) == first
    assert places(8) != first
    live.reset(seed=7)
    assert live.truth.state.passing_mm == live.state.passing_mm == first[0]


def test_what_goes_back_is_the_object_and_not_what_passes(live: LiveSensor):
    live.move_to(gap_mm=2.0)
    before = live.now()
    live.grab()
    live.move_to(gap_mm=1.0)
    live.go_back(before)
    assert live.state.gap_mm == 2.0
    assert live.state.passing_mm != before.state.passing_mm
    assert live.state == replace(before.state, passing_mm=live.state.passing_mm)


def test_moment_that_was_grabbed_is_developed_as_it_was(live: LiveSensor):
    moment = live.grab()
    live.frame()
    live.reset()
    assert (live.develop(moment).image == live.frame().image).all()


def test_lights_off_leave_the_room_with_what_passes_in_it(live: LiveSensor):
    live.set_led_strength(0, 0, 0)
    frames = [live.frame().image.astype(float) for _ in range(2)]
    assert frames[0].mean() > 1
    assert (frames[0] != frames[1]).any()


def test_facing_finger_sees_a_still_room(live: LiveSensor):
    live.face(20.0)
    assert live.state.passing_mm is None
