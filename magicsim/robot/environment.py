"""A Gymnasium environment: approach an object, press, hold, and lift it without letting it slip.

Needs the extra `robot` (gymnasium). Importing this module registers `magicsim/GraspLift-v0`.
"""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.config.ranges import check_number, check_vector
from magicsim.errors import ConfigError, MagicsimError, unknown_choice
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.lift import Lift, Reach
from magicsim.robot.live import MAX_SEED, still_to_come
from magicsim.robot.picture import Picture
from magicsim.robot.quality import find_quality
from magicsim.robot.workspace import Range
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.episode import SimulatedFrame
from magicsim.waiting import Told, on_stderr, waiting

try:
    import gymnasium
    from gymnasium import spaces
except ModuleNotFoundError as error:
    raise ConfigError(f"the environment needs {error.name}; `pip install magicsim[robot]`") from error

Observation = dict[str, Any]
"""`image`, `image_lower` and `proprioception`, all NumPy arrays."""
ENVIRONMENT_ID = "magicsim/GraspLift-v0"
SLIP_COST, FORCE_COST = 0.5, 0.1
DRAWN = ("weight_n", "gap_mm", "x_mm", "y_mm", "z_mm")
OPTIONS = (*DRAWN, "force_n", "torque_nmm")
CAMERAS = (1, 2)
LEAST, MOST = 1e-6, 1e6
"""Ends of the range of every number of the task, in its own unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepCost:
    """What one `reset` or step took."""

    solve_s: float
    """Contact and balance; in the first `reset` the sensors' geometry too [s]."""
    light_s: float
    """The pictures; in the first `reset` the untouched sensors too [s]."""


class GraspLift(gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """The two fingers of `Gripper` close on an object on a table and lift it (`magicsim.robot.lift`).

    Observation: `image` and `image_lower`, what the upper and the lower finger see, uint8 RGB of shape (rows, columns,
    3); `proprioception`, float32 of shape (4,): distance of the faces [mm], height of the fingers [mm], closing speed
    of each finger and rising speed in the last step [mm/s].

    Info: `weight_n`; `hold` (`placed` on the table, `held`, `slipped`, `dropped`); `place`, the object in the gripper's
    frame; `upper_force_n`, `lower_force_n`, `upper_torque_nmm` and `lower_torque_nmm`, the object's on each finger in
    that finger's frame; `normal_n`, the larger normal force; `carried_n`, upward force of both fingers; `slip_share`
    and `slip_mm` of the finger that slips more; `gap_mm`, mean distance of the object's sides from the faces;
    `object_mm`, its height; `has_dropped`, `is_success`; `beyond_limits`, what is above a design's limits, or empty.

    Action: float32 of shape (2,) in -1..1: closing speed of each finger and rising speed, in units of `speed_mm_s`.
    Fingers stop at the limits of depth, opening and height.

    Reward of a step: way of the object upwards / `target_mm`, less 0.5 x way of slip / `target_mm`, less 0.1 for each
    N of the larger normal force above `force_limit_n`; +1 when the task is done, -1 when the object falls to the table.

    Episode: a seed fixes the object's weight and place and every frame's noise. It terminates after `hold_steps` steps
    in a row with the object at least `target_mm` high, or when it falls to the table. It is truncated after `max_steps`
    steps, or where no valid equilibrium is found (`info["error"]` says why, the observation is of the state before).
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 15}  # noqa: RUF012 -- as in the base

    def __init__(
        self, scene: str | Path | SceneConfig = "grip", overrides: Sequence[str] = (), *, weight_n: Range = (0.5, 4.0),
        start_gap_mm: Range = (1.0, 3.0), offset_mm: float = 0.5, target_mm: float = 2.0, hold_steps: int = 5,
        max_steps: int = 120, speed_mm_s: float = 5.0, deepest_mm: float = 2.0, force_limit_n: float = 6.0,
        ends_beyond_limits: bool = False, render_mode: str | None = None, quality: str = "full", cameras: int = 2,
        told: Told = on_stderr,
    ) -> None:  # fmt: skip
        """Checks the settings; the sensors are built by the first `reset`.

        Args:
            scene: Scene preset, file or configuration: a finger, the object and the friction between them.
            overrides: `dotted.key=value` settings of a preset or file.
            weight_n: Smallest and largest weight of the object [N].
            start_gap_mm: Smallest and largest gap at the start [mm].
            offset_mm: Largest shift of the object along x, y and the closing axis at the start [mm].
            target_mm: Height to lift it to [mm].
            hold_steps: Steps for which it has to stay there.
            max_steps: Steps of an episode at most.
            speed_mm_s: Speed of a full action [mm/s].
            deepest_mm: Largest indentation of a finger [mm].
            force_limit_n: Normal force above which no finger should press [N].
            ends_beyond_limits: Whether an episode ends, as after a fall, once a finger's touch is beyond the limits of
                its design (`info["beyond_limits"]`).
            render_mode: `rgb_array`, `human` (a window on the last frames, see `magicsim.robot.picture`) or None.
            quality: `full`, or `control`: coarser and faster, see `magicsim.robot.quality`.
            cameras: 2, or 1 for the upper finger's picture alone, without `image_lower`; contact is solved for both.
            told: Hears what takes longer than two seconds; it is written to stderr by default.

        Raises:
            ConfigError: A setting is not allowed, or the scene has no object or no friction.
        """
        config = scene if isinstance(scene, SceneConfig) else load_scene(scene, overrides)
        if config.object is None or config.contact.friction == 0:
            raise ConfigError("scene: object and contact.friction are needed, without friction nothing can be lifted")
        if render_mode not in {None, *self.metadata["render_modes"]}:
            raise ConfigError(unknown_choice("render_mode", str(render_mode), self.metadata["render_modes"]))
        for name, value in (
            ("target_mm", target_mm), ("speed_mm_s", speed_mm_s), ("deepest_mm", deepest_mm),
            *(("weight_n", each) for each in weight_n), *(("start_gap_mm", each) for each in start_gap_mm),
        ):  # fmt: skip
            check_number(name, value, LEAST, MOST)
        for name, count in (("max_steps", max_steps), ("hold_steps", hold_steps)):
            check_number(name, count, 1, MOST, whole=True)
        for name, (low, high) in (("weight_n", weight_n), ("start_gap_mm", start_gap_mm)):
            if low > high:
                raise ConfigError(f"{name} = ({low:g}, {high:g}) is not allowed: must be the smaller one first")
        check_number("offset_mm", offset_mm, 0, MOST)
        check_number("force_limit_n", force_limit_n, 0, MOST)
        if cameras not in CAMERAS:
            raise ConfigError(unknown_choice("cameras", str(cameras), map(str, CAMERAS)))
        self._scene = config
        self.reach = Reach.around(
            config.object, start_gap_mm=start_gap_mm, offset_mm=offset_mm, target_mm=target_mm, deepest_mm=deepest_mm
        )
        check_number("start_gap_mm", start_gap_mm[1], LEAST, self.reach.gap_mm[1])
        self.weight_n, self.start_gap_mm, self.offset_mm = weight_n, start_gap_mm, offset_mm
        self.target_mm, self.hold_steps, self.max_steps = target_mm, hold_steps, max_steps
        self.speed_mm_s, self.force_limit_n, self.render_mode = speed_mm_s, force_limit_n, render_mode
        self.ends_beyond_limits = ends_beyond_limits
        self.quality, self.cameras, self._told = find_quality(quality), cameras, told
        self._picture: Picture | None = None
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = self._observed_space()
        self._gripper: Gripper | None = None
        self._lift: Lift | None = None
        self._frames: tuple[SimulatedFrame, ...] = ()
        self._steps = self._held = 0
        self._is_over = False
        self.cost = StepCost(solve_s=0.0, light_s=0.0)
        """StepCost of the last `reset` or step; zero before."""
        self._begun = 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode.

        Args:
            seed: Of weight, place and noise.
            options: Values instead of drawn ones: `weight_n`, `gap_mm` (mean distance of the object's sides from the
                faces), `x_mm`, `y_mm`, `z_mm` (along the closing axis, 0 midway); and an outer `force_n` and
                `torque_nmm` on the object while the fingers hold it, each of three numbers, none by default.

        Raises:
            ConfigError: An option that does not exist or is outside of the workspace.
        """
        super().reset(seed=seed)
        self._begun = time.perf_counter()
        given = dict(options or {})
        for name in given:
            if name not in OPTIONS:
                raise ConfigError(unknown_choice("option", name, OPTIONS))
        random = self.np_random
        noise = int(random.integers(MAX_SEED))
        ranges = (self.weight_n, self.start_gap_mm, *((-self.offset_mm, self.offset_mm),) * 3)
        drawn = {name: float(random.uniform(*each)) for name, each in zip(DRAWN, ranges, strict=True)}
        weight, gap, *place = (given.pop(name, value) for name, value in drawn.items())
        check_number("weight_n", weight, LEAST, MOST)
        check_number("gap_mm", gap, *self.reach.gap_mm)
        for name, value in zip(DRAWN[2:], place, strict=True):
            check_number(name, value, -MOST, MOST)
        for name, value in given.items():
            check_vector(name, value, -MOST, MOST)
        load = Load(weight_n=weight, **{name: tuple(value) for name, value in given.items()})
        start = ObjectPlace(x_mm=place[0], y_mm=place[1], z_mm=place[2])
        with waiting("resetting the environment", self._told):
            if self._gripper is None:
                space = self.reach.workspace
                self._gripper = Gripper(self._scene, workspace=space, quality=self.quality, told=self._told)
            self._lift = None  # until all of it is reset, whatever interrupts it
            self._gripper.reset(seed=noise)
            lift = Lift(self._gripper, load=load, width_mm=self.reach.width_at_mm(gap), place=start)
            observed = self._observe(lift, np.zeros(2)), self._info(lift)
            self._lift, self._steps, self._held, self._is_over = lift, 0, 0, False
            return observed

    def step(self, action: npt.NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Moves the fingers for the time of one frame.

        Args:
            action: Closing and rising speed in -1..1, shape (2,); beyond that it is clipped.

        Raises:
            ConfigError: `reset` was not called, the episode has ended, or the action is not two finite numbers; nothing
                moves then.
        """
        if self._lift is None:
            raise ConfigError("step is not allowed yet: call reset() first")
        if self._is_over:
            raise ConfigError("step is not allowed any more: the episode has ended, call reset() first")
        speeds, lift = self._checked(action), self._lift
        before = lift.gripper.now(), lift.state, self._steps, self._held, self._frames
        try:
            with waiting("a step of the environment", self._told), still_to_come(*lift.gripper.fingers):
                result = self._step(lift, speeds)
                self._is_over = result[2] or result[3]
                return result
        except BaseException:
            self._is_over = False
            moment, lift.state, self._steps, self._held, self._frames = before
            lift.gripper.go_back(moment)
            raise

    def _checked(self, action: object) -> npt.NDArray[np.float64]:
        try:
            speeds = np.asarray(action, np.float64)
        except (TypeError, ValueError):  # words, rows of unequal length
            speeds = np.full(2, np.nan)
        if speeds.shape != (2,) or not np.isfinite(speeds).all():
            given = " ".join(str(action).split())
            raise ConfigError(f"action = {given} is not allowed: must be two finite numbers, closing and rising speed")
        return speeds

    def _step(
        self, lift: Lift, action: npt.NDArray[np.float64]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self._begun = time.perf_counter()
        before, dt_s = lift.state, 1 / self._scene.frames_per_second
        gap = self.reach.gap_at_mm(before.width_mm)
        asked = np.clip(action, -1, 1) * self.speed_mm_s * dt_s
        closing = gap - float(np.clip(gap - asked[0], *self.reach.gap_mm))
        rising = float(np.clip(before.finger_mm + asked[1], *self.reach.finger_mm)) - before.finger_mm
        self._steps += 1
        try:
            state = lift.step(closing_mm=closing, rising_mm=rising)
        except MagicsimError as error:
            return self._observe(lift, np.zeros(2)), 0.0, False, True, {**self._info(lift), "error": str(error)}
        self._held = self._held + 1 if state.object_mm >= self.target_mm else 0
        is_done = self._held >= self.hold_steps
        reward = (state.object_mm - before.object_mm - SLIP_COST * state.slip_mm) / self.target_mm
        reward -= FORCE_COST * max(0.0, state.normal_n - self.force_limit_n)
        info = {**self._info(lift), "is_success": is_done}
        has_failed = state.has_dropped or (self.ends_beyond_limits and bool(info["beyond_limits"]))
        reward += float(is_done) - float(has_failed)
        speeds = np.array([closing, rising]) / dt_s
        is_over, is_late = is_done or has_failed, self._steps >= self.max_steps
        return self._observe(lift, speeds), float(reward), is_over, is_late, info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The last frames side by side, RGB of shape (rows, cameras x columns, 3), in mode `rgb_array`; or shown."""
        if self.render_mode is None or not self._frames:
            return None
        side_by_side = np.hstack([frame.image for frame in self._frames])
        if self.render_mode == "rgb_array":
            return side_by_side
        if self._picture is None:
            self._picture = Picture("magicsim GraspLift")
        self._picture.show(side_by_side)
        return None

    def close(self) -> None:
        """Lets go of the sensors; may be called again."""
        if self._gripper is not None:
            self._gripper.release()
        if self._picture is not None:
            self._picture.close()
        self._gripper, self._lift, self._frames, self._picture = None, None, (), None

    @property
    def frame(self) -> SimulatedFrame | None:
        """The upper finger's last frame with its ground truth, None before the first `reset`."""
        return self._frames[0] if self._frames else None

    @property
    def frames(self) -> tuple[SimulatedFrame, ...]:
        """The last frames with their ground truth, upper and lower, none before the first `reset`."""
        return self._frames

    def _observed_space(self) -> spaces.Dict:
        camera, speed = self._scene.rig.camera, self.speed_mm_s
        limits = [[self.reach.width_at_mm(gap) for gap in self.reach.gap_mm], self.reach.finger_mm]
        low, high = np.array([*limits, (-speed, speed), (-speed, speed)], np.float32).T
        slack = 1e-3  # of rounding in float32
        image = spaces.Box(0, 255, (camera.window.rows, camera.window.columns, 3), np.uint8)
        proprioception = spaces.Box(low - np.float32(slack), high + np.float32(slack), dtype=np.float32)
        return spaces.Dict({**dict.fromkeys(self._images, image), "proprioception": proprioception})

    @property
    def _images(self) -> tuple[str, ...]:
        return ("image", "image_lower")[: self.cameras]

    def _observe(self, lift: Lift, speeds_mm_s: npt.NDArray[np.float64]) -> Observation:
        solved = time.perf_counter()
        state = lift.state
        self._frames = tuple(finger.frame() for finger in lift.gripper.fingers[: self.cameras])
        self.cost = StepCost(solve_s=solved - self._begun, light_s=time.perf_counter() - solved)
        if self.render_mode == "human":
            self.render()
        images = {name: frame.image.copy() for name, frame in zip(self._images, self._frames, strict=True)}
        values = [state.width_mm, state.finger_mm, *speeds_mm_s]
        return {**images, "proprioception": np.array(values, np.float32)}

    def _info(self, lift: Lift) -> dict[str, Any]:
        state, upper, lower = lift.state, *(finger.truth for finger in lift.gripper.fingers)
        return {
            "weight_n": lift.load.weight_n,
            "hold": str(state.hold),
            "place": asdict(lift.gripper.place),
            "upper_force_n": upper.force_n,
            "lower_force_n": lower.force_n,
            "upper_torque_nmm": upper.torque_nmm,
            "lower_torque_nmm": lower.torque_nmm,
            "normal_n": state.normal_n,
            "carried_n": state.carried_n,
            "slip_share": state.slip_share,
            "slip_mm": state.slip_mm,
            "gap_mm": self.reach.gap_at_mm(state.width_mm),
            "object_mm": state.object_mm,
            "has_dropped": state.has_dropped,
            "beyond_limits": upper.beyond_limits or lower.beyond_limits,
            "is_success": False,
        }


gymnasium.register(ENVIRONMENT_ID, entry_point="magicsim.robot.environment:GraspLift")
