import subprocess
import sys
from collections.abc import Iterator
from functools import partialmethod
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from laboratory.interrupts import differences

from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.limits import PressLimits
from magicsim.scenes.scene import load_scene
from magicsim.simulation.sensor import Sensor

from .conftest import TINY

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from magicsim.robot.environment import ENVIRONMENT_ID, GraspLift  # noqa: E402

QUICK = [*TINY, "output.contact_mask=false", "output.displacements=false"]


@pytest.fixture(scope="module")
def shared_env() -> Iterator[Any]:
    env = gymnasium.make(ENVIRONMENT_ID, overrides=QUICK, render_mode="rgb_array", disable_env_checker=True).unwrapped
    yield env
    env.close()


@pytest.fixture
def env(shared_env: GraspLift, monkeypatch: pytest.MonkeyPatch) -> GraspLift:
    monkeypatch.setattr(shared_env, "max_steps", 120)
    return shared_env


@pytest.fixture
def unlit(env: GraspLift, monkeypatch: pytest.MonkeyPatch) -> Iterator[GraspLift]:
    """Every frame shows the first picture, with noise of its own: for what no picture tells."""
    monkeypatch.setattr(Sensor, "render", partialmethod(_first_picture, [], Sensor.render))
    yield env
    for finger in env._gripper.fingers:
        finger._darkroom._seen.clear()


def _first_picture(sensor: Sensor, shown: list[Any], render: Any, *state: Any) -> Any:
    shown[:] = shown or [render(sensor, *state)]
    return shown[0]


def action(closing: float, rising: float) -> np.ndarray:
    return np.array([closing, rising], np.float32)


def test_it_passes_gymnasiums_own_check(unlit: GraspLift):
    check_env(unlit, skip_render_check=True)  # which would open a window; the pictures are looked at below


def test_frames_come_in_pairs_with_forces_on_both_faces_and_the_place_of_the_object(env: GraspLift):
    seen, info = env.reset(seed=7, options={"gap_mm": 0.05, "z_mm": 0.0})
    assert (seen["image"] != seen["image_lower"]).any()
    assert (info["hold"], info["upper_force_n"], info["lower_force_n"]) == ("placed", (0, 0, 0), (0, 0, 0))
    seen, _, _, _, info = env.step(action(1, 0))
    assert info["upper_force_n"][2] == pytest.approx(info["lower_force_n"][2], abs=0.01)
    assert info["normal_n"] == max(info["upper_force_n"][2], info["lower_force_n"][2]) > 0
    assert [frame.image.tolist() for frame in env.frames] == [seen[name].tolist() for name in ("image", "image_lower")]
    assert env.frames[1].truth.force_n == info["lower_force_n"]


@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros(3), np.zeros(1), np.zeros((2, 1)), 0.5, None, "10", [[0.1], [0.1, 0.2]], [np.nan, 0.0], [0.0, np.inf],
        {"closing": 1.0}, [1 + 2j, 0],
    ],
)  # fmt: skip
def test_action_that_is_no_two_finite_numbers_is_an_error_and_moves_nothing(
    wrong: object, monkeypatch: pytest.MonkeyPatch
):
    env = GraspLift(overrides=QUICK)
    monkeypatch.setattr(env, "_lift", SimpleNamespace(step=lambda **_: pytest.fail("moved")))
    with pytest.raises(ConfigError, match=r"^action = .* is not allowed: must be two finite numbers, closing and risi"):
        env.step(wrong)
    assert env._steps == 0


def test_one_camera_gives_the_upper_fingers_picture_alone(unlit: GraspLift):
    del unlit
    env = GraspLift(overrides=QUICK, cameras=1)
    assert set(env.observation_space) == {"image", "proprioception"}
    seen, _ = env.reset(seed=1)
    assert set(seen) == {"image", "proprioception"}
    assert len(env.frames) == 1
    env.close()


@pytest.mark.slow
def test_outer_force_is_felt_once_the_object_is_in_the_air(env: GraspLift):
    env.reset(seed=3, options={"gap_mm": 0.05, "weight_n": 0.2, "x_mm": 0.0, "force_n": (0.2, 0, 0)})
    env.step(action(1, 0))
    info = env.step(action(0.3, 0.6))[-1]
    assert info["hold"] in {"held", "slipped"}
    assert info["lower_force_n"][0] < 0 < info["upper_force_n"][0]  # their x axes point apart


def test_seed_repeats_observations_rewards_and_truth(env: GraspLift):
    def episode() -> list[Any]:
        return [env.reset(seed=7, options={"gap_mm": 0.1}), env.step(action(1, 0.2))]

    one, two = episode(), episode()
    for a, b in zip(one, two, strict=True):
        assert set(a[0]) == {"image", "image_lower", "proprioception"}
        assert all((a[0][name] == b[0][name]).all() for name in a[0])
        assert a[1:] == b[1:]
    assert one[-1][-1]["normal_n"] > 0
    other = env.reset(seed=8)
    assert other[1]["weight_n"] != one[0][1]["weight_n"]


def test_observation_tells_opening_height_and_speeds(unlit: GraspLift):
    first, _ = unlit.reset(seed=1, options={"gap_mm": 2.0})
    assert first["proprioception"] == pytest.approx([2 * (2 + 4), 0, 0, 0])
    second = unlit.step(action(0.6, 0.3))[0]
    assert second["proprioception"] == pytest.approx([2 * (1.8 + 4), 0.1, 3.0, 1.5])
    assert (unlit.render() == np.hstack([second["image"], second["image_lower"]])).all()
    assert (unlit.frame.image == second["image"]).all()


def test_fingers_stop_at_their_limits(unlit: GraspLift):
    unlit.reset(seed=1, options={"gap_mm": 5.9})
    observation = unlit.step(action(-1, -1))[0]
    assert observation["proprioception"] == pytest.approx([2 * (6 + 4), 0, -1.5, 0])


@pytest.mark.slow
def test_reward_is_the_documented_one(env: GraspLift, monkeypatch: pytest.MonkeyPatch):
    env.reset(seed=1, options={"gap_mm": 0.1, "weight_n": 0.2})
    before = env.step(action(1, 0))[4]
    monkeypatch.setattr(env, "force_limit_n", 0.1)
    reward, info = env.step(action(0, 1))[1::3]
    progress = (info["object_mm"] - before["object_mm"]) / 2.0
    assert progress > 0.05
    assert reward == pytest.approx(progress - 0.5 * info["slip_mm"] / 2.0 - 0.1 * (info["normal_n"] - 0.1))


@pytest.mark.slow
def test_grasp_that_is_firm_enough_lifts_and_holds(env: GraspLift, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(env, "target_mm", 0.5)
    monkeypatch.setattr(env, "hold_steps", 2)
    env.reset(seed=1, options={"gap_mm": 0.1, "weight_n": 1.0})
    rewards = []
    for number in range(12):
        _, reward, is_over, _, info = env.step(action(1, 0) if number < 3 else action(0, 1))
        rewards.append(reward)
        if is_over:
            break
    assert info["is_success"]
    assert rewards[-1] > 1
    assert info["carried_n"] == pytest.approx(1.0, rel=0.01)
    for _ in range(3):
        _, reward, is_over, _, info = env.step(action(-1, 0))
        if is_over and info["has_dropped"]:
            break
    assert info["has_dropped"]
    assert reward < -1


def test_episode_ends_after_its_last_step(unlit: GraspLift, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(unlit, "max_steps", 2)
    unlit.reset(seed=1)
    assert unlit.step(action(0, 0))[2:4] == (False, False)
    assert unlit.step(action(0, 0))[2:4] == (False, True)
    with pytest.raises(ConfigError, match=r"the episode has ended, call reset\(\) first"):
        unlit.step(action(0, 0))


def test_step_without_an_equilibrium_ends_the_episode_and_shows_the_state_before(
    unlit: GraspLift, monkeypatch: pytest.MonkeyPatch
):
    def fail(*_: object, **__: object) -> None:
        msg = "no equilibrium"
        raise ConvergenceError(msg)

    unlit.reset(seed=1, options={"gap_mm": 2.0})
    monkeypatch.setattr("magicsim.robot.lift.Lift.step", fail)
    observation, reward, is_over, is_late, info = unlit.step(action(1, 0))
    assert (reward, is_over, is_late, info["error"]) == (0.0, False, True, "no equilibrium")
    assert observation["proprioception"][0] == pytest.approx(12)


@pytest.mark.parametrize("is_asked", [False, True])
def test_episode_may_end_where_the_print_bears_no_more(
    unlit: GraspLift, monkeypatch: pytest.MonkeyPatch, *, is_asked: bool
):
    monkeypatch.setattr(unlit, "ends_beyond_limits", is_asked)
    monkeypatch.setattr(PressLimits, "excess", lambda *_, **__: "7 N is above")
    unlit.reset(seed=1, options={"gap_mm": 2.0})
    _, reward, is_over, is_late, info = unlit.step(action(0, 0))
    assert (reward, is_over, is_late, info["beyond_limits"]) == (-float(is_asked), is_asked, False, "7 N is above")


def test_options_that_do_not_exist_or_are_outside_are_refused(env: GraspLift):
    with pytest.raises(ConfigError, match="unknown option 'weight'"):
        env.reset(options={"weight": 1})
    with pytest.raises(ConfigError, match="gap_mm = 99 is not allowed"):
        env.reset(options={"gap_mm": 99})
    with pytest.raises(ConfigError, match="x_mm = 7 is not allowed"):
        env.reset(options={"x_mm": 7})
    with pytest.raises(ConfigError, match="weight_n = 'a' is not allowed: must be a number"):
        env.reset(options={"weight_n": "a"})
    with pytest.raises(ConfigError, match="z_mm = None is not allowed"):
        env.reset(options={"z_mm": None})
    with pytest.raises(ConfigError, match="force_n = 3 is not allowed: must be 3 numbers"):
        env.reset(options={"force_n": 3})
    with pytest.raises(ConfigError, match=r"load.force_n = 1e\+06 is not allowed"):
        env.reset(options={"force_n": (1e6, 0, 0)})


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scene": "pressed"}, "contact.friction are needed"),
        ({"scene": "rest"}, "contact.friction are needed"),
        ({"target_mm": 0}, "target_mm = 0 is not allowed: must be a number of at least 1e-06"),
        ({"weight_n": (4.0, 0.5)}, r"weight_n = \(4, 0.5\) is not allowed: must be the smaller one first"),
        ({"max_steps": 2.5}, "max_steps = 2.5 is not allowed: must be a whole number"),
        ({"overrides": ["object.radius_mm=49.5"]}, "start_gap_mm = 3 is not allowed: must be .* at most 1.46"),
        ({"render_mode": "ansi"}, "unknown render_mode 'ansi'"),
        ({"deepest_mm": 4.5}, "fingers would pass through each other, must be below 4.18"),
        ({"cameras": 3}, "unknown cameras '3'"),
        ({"overrides": ["object.radius_mm=60"]}, "object 'sphere' does not fit between the fingers: 120 mm along"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, Any], message: str):
    with pytest.raises(ConfigError, match=message):
        GraspLift(**settings)


def test_step_before_reset_and_after_close_is_refused():
    env = GraspLift(load_scene("grip", QUICK))
    with pytest.raises(ConfigError, match=r"call reset\(\) first"):
        env.step(action(0, 0))
    env.close()
    env.close()
    assert env.render() is None


def test_missing_extra_is_named():
    code = "import sys; sys.modules['gymnasium'] = None\nfrom magicsim.robot import GraspLift"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr.strip().endswith("the environment needs gymnasium; `pip install magicsim[robot]`")


def test_cost_of_a_step_is_told_beside_the_repeatable_info(env: GraspLift):
    _, info = env.reset(seed=1)
    assert env.cost.solve_s > 0
    assert env.cost.light_s > 0
    assert not any("second" in name or "cost" in name for name in info)


def test_human_mode_shows_every_frame(unlit: GraspLift, monkeypatch: pytest.MonkeyPatch):
    shown: list[np.ndarray] = []

    class Screen:
        def __init__(self, title: str) -> None:
            assert "GraspLift" in title

        def show(self, image: np.ndarray) -> None:
            shown.append(image)

        def close(self) -> None:
            shown.clear()

    monkeypatch.setattr("magicsim.robot.environment.Picture", Screen)
    monkeypatch.setattr(unlit, "render_mode", "human")
    unlit.reset(seed=1)
    unlit.step(action(0, 0))
    assert len(shown) == 2
    assert unlit.render() is None
    assert len(shown) == 3


@pytest.mark.slow
def test_two_processes_step_at_once():
    settings = {"overrides": QUICK, "vector_kwargs": {"context": "spawn"}}
    both = gymnasium.make_vec(ENVIRONMENT_ID, num_envs=2, vectorization_mode="async", **settings)
    try:
        seen, _ = both.reset(seed=[1, 2])
        assert seen["image"].shape == seen["image_lower"].shape == (2, 32, 24, 3)
        rewards = both.step(np.zeros((2, 2), np.float32))[1]
        assert np.isfinite(rewards).all()
        assert all(cost.light_s > 0 for cost in both.get_attr("cost"))
    finally:
        both.close()


def test_reset_and_step_speak_for_all_that_they_do(
    unlit: GraspLift, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("magicsim.waiting.FIRST_S", 0.0)
    monkeypatch.setattr("magicsim.waiting.NEXT_S", 0.001)
    unlit.reset(seed=2, options={"gap_mm": 0.05})
    lines = capsys.readouterr().err.splitlines()
    assert {line.split(",")[0].split(":")[1] for line in lines} == {" resetting the environment"}
    assert any(": rendering " in line for line in lines)
    unlit.step(action(1, 0))
    lines = capsys.readouterr().err.splitlines()
    assert {line.split(",")[0].split(":")[1] for line in lines} == {" a step of the environment"}
    assert any(": solving the contact, " in line for line in lines)


@pytest.mark.parametrize(
    ("most", "kind"),
    [(1, "unlit"), pytest.param(1, "env", marks=pytest.mark.slow), pytest.param(None, "env", marks=pytest.mark.slow)],
)
def test_step_that_is_interrupted_has_not_happened(request: pytest.FixtureRequest, most: int | None, kind: str):
    env = request.getfixturevalue(kind)

    def told(result: tuple[Any, ...]) -> bytes:
        seen, *rest = result
        return b"".join(seen[name].tobytes() for name in sorted(seen)) + repr(rest).encode()

    steps = {
        "reset": lambda: told(env.reset(seed=7, options={"gap_mm": 0.05, "z_mm": 0.0})),
        "first": lambda: told(env.step(action(1, 0))),
        "second": lambda: told(env.step(action(1, 0.2))),
    }
    assert differences(steps, most=most, within="robot") == []
