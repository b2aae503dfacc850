"""The gripper of docs/examples lifts its ball, headless."""

import importlib.util
from pathlib import Path

import pytest

from magicsim.scenes.scene import SceneConfig

from .models import mujoco  # noqa: F401 -- skips where it is missing

EXAMPLE = Path(__file__).resolve().parents[4] / "docs" / "examples" / "mujoco_gripper.py"


def test_two_sensors_lift_a_ball_and_carry_its_weight(block: SceneConfig):
    spec = importlib.util.spec_from_file_location(EXAMPLE.stem, EXAMPLE)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    end = script.run(block, pictures=False)
    assert end["height_mm"] == pytest.approx(1000 * script.LIFTED_M, abs=1.5)
    assert end["carried_n"] == pytest.approx(end["weight_n"], rel=0.05)
    last = end["rows"][-1]
    assert last["left"][2] == pytest.approx(last["right"][2], rel=0.02)
    assert last["left"][2] > 0.5
    assert len(end["rows"]) == 13
