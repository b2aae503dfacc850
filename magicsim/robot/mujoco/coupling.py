"""Steps a MuJoCo model with magicsim's sensors in it.

In each step of MuJoCo: positions and velocities, the wrench of every sensor, MuJoCo's integration. The wrench is

    f = f_0 + K (x - x_0) + D v,   D = damping_s K

with the equilibrium f_0 and tangent K of the last solve at x_0, and a viscous part, since the body is solved
quasi-statically. A contact is solved again as soon as the body has moved farther than the linear answer is trusted
(`trust`), and for every frame. The viscous part is implicit in itself: with the mobility W = J M^-1 J^T of all sensors
together, D v is replaced by (1 + dt D W)^-1 D v, which brakes at any stiffness and vanishes at rest. The elastic part
is explicit, as MuJoCo's semi-implicit Euler has it, and stable for dt^2 max eig(W K) < 2, which is checked after each
solve.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.pose import Pose
from magicsim.robot.darkroom import Moment
from magicsim.robot.grip.pair import finger_seed
from magicsim.robot.mujoco.attached import AttachedSensor, Trust
from magicsim.robot.mujoco.pair import Touch
from magicsim.robot.mujoco.solids import MM, MjData, MjModel, engine
from magicsim.robot.quality import Quality, find_quality
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.episode import FrameTruth, SimulatedFrame
from magicsim.simulation.sensor import Sensor

STABLE = 2.0
"""Squared product of time step and frequency of the contact up to which the integration is stable."""
DAMPING_S = 0.005
"""Ratio of damping to stiffness: the body loses as much as rubber with a loss factor of 0.5 at 16 Hz. Assumed [s]."""


class Coupling:
    """A MuJoCo model whose sensors press back: moved by `step`, frames at the camera's rate."""

    def __init__(
        self, model: MjModel, data: MjData, touches: Sequence[Touch], *, scene: SceneConfig | None = None,
        quality: str | Quality = "control", tolerance_n: float = 0.02, damping_s: float = DAMPING_S,
        seed: int | None = None,
    ) -> None:  # fmt: skip
        """Attaches the sensors.

        Args:
            model: `mujoco.MjModel`.
            data: Its `mujoco.MjData`, which `step` moves on. Forces that the caller puts there stay as they are.
            touches: Sensors and the bodies that they touch.
            scene: For touches without a scene of their own; the preset `grip` by default.
            quality: `full` or `control`, see `magicsim.robot.quality`.
            tolerance_n: Error of the force between two solves that is aimed at [N].
            damping_s: Ratio of damping to stiffness [s]; 0 is elastic.
            seed: Of the frames' noise; the scene's by default.

        Raises:
            ConfigError: A name does not exist, a body cannot press, MuJoCo would press it too, the integrator is not
                allowed, the cameras have no common rate or are faster than the model, or a number is out of range.
            MagicsimError: A sensor cannot be built.
        """
        check_number("tolerance_n", tolerance_n, 1e-6, 10)
        check_number("damping_s", damping_s, 0, 1)
        names = [touch.site for touch in touches]
        if not names:
            raise ConfigError("touches is empty: a coupling needs at least one sensor")
        if len(set(names)) < len(names):
            raise ConfigError(f"touches have the same site twice ({', '.join(names)}): a sensor touches one body")
        if model.opt.integrator == engine().mjtIntegrator.mjINT_RK4:
            msg = "integrator = RK4 is not allowed: contact is answered once a step; must be Euler or an implicit one"
            raise ConfigError(msg)
        self.model, self.data, self._damping_s = model, data, damping_s
        usual = scene or next((touch.scene for touch in touches if touch.scene is not None), None) or load_scene("grip")
        _check_rates(float(model.opt.timestep), {touch.site: touch.scene or usual for touch in touches})
        grade, trust = find_quality(quality), Trust(tolerance_n=tolerance_n)
        self.sensors: dict[str, AttachedSensor] = {}
        """The attached sensors by the names of their sites."""
        for number, touch in enumerate(touches):
            self.sensors[touch.site] = AttachedSensor(
                model, touch, touch.scene or usual, quality=grade, trust=trust,
                seed=finger_seed(usual.seed if seed is None else seed, number), opposite=partial(self._opposite, touch),
            )  # fmt: skip
        self.frames_per_second = usual.frames_per_second
        self._facing = self._facing_pairs()
        self.reset()

    def reset(self) -> None:
        """Forgets every contact and begins the streams of frames, after the caller has reset the data."""
        for sensor in self.sensors.values():
            sensor.reset()
        self._frames, self._start_s = 0, float(self.data.time)
        self._wrenches: dict[str, Array] = {name: np.zeros(6) for name in self.sensors}

    def wrench(self, site: str) -> Array:
        """Force [N] and torque [N mm] on the sensor of a site, viscous part included, about its origin, shape (6,)."""
        return self._wrenches[site].copy()

    def step(self) -> dict[str, Moment] | None:
        """One step of MuJoCo.

        Returns:
            The moment of each sensor's frame at the begin of the step, where the cameras take one; otherwise None.

        Raises:
            ConfigError: The time step is too long for the stiffness of a contact, or sensors that are said to do not
                face each other.
            ConvergenceError: A contact has no valid equilibrium; model and sensors have not moved.
        """
        with self._whole():
            return self._step()

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """A step of which nothing has happened to model and sensors where it fails or is interrupted."""
        data, spec = self.data, int(engine().mjtState.mjSTATE_INTEGRATION)
        before = np.empty(engine().mj_stateSize(self.model, spec))
        engine().mj_getState(self.model, data, before, spec)
        kept = [(each, dict(vars(each))) for each in (self, *self.sensors.values())]
        try:
            yield
        except BaseException:
            engine().mj_setState(self.model, data, before, spec)
            for each, state in kept:
                vars(each).update(state)
            raise

    def _step(self) -> dict[str, Moment] | None:
        engine().mj_step1(self.model, self.data)
        time_s = float(self.data.time)
        is_due = time_s - self._start_s >= (self._frames / self.frames_per_second) - self.model.opt.timestep / 2
        poses = {name: sensor.pose(self.data) for name, sensor in self.sensors.items()}
        solved = [name for name, pose in poses.items() if is_due or self.sensors[name].needs_solve(pose)]
        for name in solved:
            self.sensors[name].solve(poses[name])
        rows = np.concatenate([sensor.motion_rows(self.model, self.data) for sensor in self.sensors.values()])
        self._answer(poses, rows, is_new=bool(solved))
        for sensor, other in self._facing if is_due else ():
            sensor.face(self.data, other)
        kept = self.data.xfrc_applied.copy()
        self._apply()
        engine().mj_step2(self.model, self.data)
        self.data.xfrc_applied[:] = kept
        if not is_due:
            return None
        self._frames += 1
        return {name: sensor.grab(time_s) for name, sensor in self.sensors.items()}

    def develop(self, moments: Mapping[str, Moment]) -> dict[str, SimulatedFrame]:
        """Renders the frames of moments from `step`; `RenderError` where an image is not valid."""
        return {name: self.sensors[name].develop(moment) for name, moment in moments.items()}

    def truths(self, moments: Mapping[str, Moment]) -> dict[str, FrameTruth]:
        """Ground truth of moments from `step`, without rendering them: forces in each sensor's frame."""
        return {name: each.truth(self.sensors[name].sensor.design.limits) for name, each in moments.items()}

    def _facing_pairs(self) -> list[tuple[AttachedSensor, AttachedSensor]]:
        """Each sensor that looks at another one, with that."""
        found = []
        for sensor in self.sensors.values():
            faces = sensor.touch.faces
            if faces is None:
                continue
            if faces not in self.sensors or faces == sensor.touch.site:
                others = [name for name in self.sensors if name != sensor.touch.site]
                raise ConfigError(unknown_choice("faces", faces, others))
            found.append((sensor, self.sensors[faces]))
        return found

    def _opposite(self, touch: Touch) -> Sensor | None:
        """The sensor that another one looks at, None where both are alike."""
        if touch.faces is None:
            return None
        own, other = (self.sensors[site].sensor for site in (touch.site, touch.faces))
        return other if (own.design, own.rig) != (other.design, other.rig) else None

    def _answer(self, poses: Mapping[str, Pose], rows: Array, *, is_new: bool) -> None:
        """The wrench on every sensor; see the head of this module."""
        names = list(self.sensors)
        elastic = {name: self.sensors[name].wrench(poses[name]) for name in names}
        acting = [number for number, name in enumerate(names) if elastic[name].any()]
        self._wrenches = elastic
        if not acting:
            return
        own = np.concatenate([rows[6 * number : 6 * number + 6] for number in acting])
        stiffness = np.zeros((len(own), len(own)))
        for place, number in enumerate(acting):
            response = self.sensors[names[number]].response
            if response is not None:
                stiffness[6 * place : 6 * place + 6, 6 * place : 6 * place + 6] = response.stiffness
        moved = np.zeros_like(own)
        engine().mj_solveM(self.model, self.data, moved, np.ascontiguousarray(own))
        mobility = own @ moved.T / MM
        dt = float(self.model.opt.timestep)
        if is_new:
            self._check_step(mobility @ stiffness, dt)
        if self._damping_s == 0:
            return
        damping = self._damping_s * stiffness
        viscous = np.linalg.solve(np.eye(len(own)) + dt * damping @ mobility, damping @ (own @ self.data.qvel))
        for place, number in enumerate(acting):
            whole = elastic[names[number]] + viscous[6 * place : 6 * place + 6]
            self._wrenches[names[number]] = whole if whole[2] > 0 else np.zeros(6)

    def _check_step(self, product: Array, dt: float) -> None:
        rate = float(np.abs(np.linalg.eigvals(product)).max())
        if dt * dt * rate >= STABLE:
            raise ConfigError(
                f"timestep = {dt:g} s is too long for a contact of this stiffness and mass at {self.data.time:.3f} s: "
                f"must be below {np.sqrt(STABLE / rate):.2g} s"
            )

    def _apply(self) -> None:
        """Adds every wrench to the body and its reaction to the finger, both at the sensor's origin."""
        data = self.data
        for name, sensor in self.sensors.items():
            wrench = self._wrenches[name]
            if not wrench.any():
                continue
            site = sensor.pair.site
            turn, point = data.site_xmat[site].reshape(3, 3), data.site_xpos[site]
            force, torque = turn @ wrench[:3], turn @ wrench[3:] / MM
            for body, sign in ((sensor.pair.body, -1.0), (sensor.pair.finger, 1.0)):
                data.xfrc_applied[body, :3] += sign * force
                data.xfrc_applied[body, 3:] += sign * (torque + np.cross(point - data.xipos[body], force))


def _check_rates(timestep_s: float, scenes: Mapping[str, SceneConfig]) -> None:
    """Refuses cameras that do not film together, or faster than the model moves."""
    rates = {site: scene.frames_per_second for site, scene in scenes.items()}
    first = next(iter(rates))
    for site, rate in rates.items():
        if rate != rates[first]:
            raise ConfigError(
                f"frames_per_second = {rate:g} of site '{site}' is not allowed: must be {rates[first]:g}, as of site "
                f"'{first}': all sensors of a coupling film together"
            )
    if timestep_s * rates[first] > 1:
        raise ConfigError(
            f"timestep = {timestep_s:g} s is not allowed: must be at most {1 / rates[first]:.4g} s, the time of a frame"
        )
