"""The examples of docs/examples run, and on a real capture as on the simulated one."""

import importlib.util
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import cv2
import numpy as np
import pytest

from magicsim.detectors import DetectorProfile
from magicsim.robot.capture import SimulatedCapture
from magicsim.robot.live import LiveSensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.timeline import UNTOUCHED

from .conftest import TINY

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_every_example_says_how_it_is_run(path: Path):
    assert f"python docs/examples/{path.name}" in path.read_text(encoding="utf-8")


def test_touch_is_watched_alike_through_a_real_capture_and_the_simulated_one(live: LiveSensor, tmp_path: Path):
    watch = example("watch_touch").watch
    profile, kept = DetectorProfile(polarity="bright"), []

    def world(sensor: LiveSensor, time_s: float) -> None:
        if time_s > 2.1:
            sensor.move_to(gap_mm=0.5)

    class Recorded(SimulatedCapture):
        def read(self, image: np.ndarray | None = None) -> tuple[bool, np.ndarray | None]:
            is_read, frame = super().read(image)
            kept.append(frame)
            return is_read, frame

    simulated = watch(Recorded(live, world=world), frames=4, profile=profile)
    for number, frame in enumerate(kept):
        cv2.imwrite(str(tmp_path / f"{number:03d}.png"), frame)
    real = cv2.VideoCapture(str(tmp_path / "%03d.png"))
    assert watch(real, frames=4, profile=profile) == simulated
    assert min(verdict.entropy for verdict in simulated[2:]) > max(verdict.entropy for verdict in simulated[:2])


def test_camera_without_frames_ends_the_example():
    watch = example("watch_touch").watch
    with pytest.raises(SystemExit, match="the camera gives no frame"):
        watch(cv2.VideoCapture(), frames=1, profile=DetectorProfile())


def test_ball_of_the_example_stays_away_presses_shears_and_leaves():
    touch, poses = example("watch_touch").touch, []
    sensor = SimpleNamespace(move_to=lambda **pose: poses.append(pose))
    for frame in range(60):
        touch(sensor, frame / 15)
    assert len(poses) == 30
    gaps = [pose["gap_mm"] for pose in poses]
    assert gaps[0] == 6
    assert min(gaps) == pytest.approx(-1.2)
    assert gaps[-1] > 5
    sheared = [pose["x_mm"] for pose in poses if pose["gap_mm"] < -1.19]
    assert sheared == pytest.approx([2 * frame / 15 for frame in range(8)])
    for pose in poses:
        Workspace(twist_deg=(0, 0)).check(replace(UNTOUCHED, **pose))


@pytest.mark.slow
def test_object_is_lifted_without_slip():
    pytest.importorskip("gymnasium")
    from magicsim.robot.environment import GraspLift

    env = GraspLift("grip", [*TINY, "output.contact_mask=false", "output.displacements=false"], target_mm=0.6)
    end = example("lift_without_slip").lift(env, seed=0, options={"weight_n": 1.5, "gap_mm": 0.3})
    env.close()
    assert end["is_success"]
    assert end["carried_n"] == pytest.approx(1.5, rel=0.01)
    assert end["reward"] > 1.5
