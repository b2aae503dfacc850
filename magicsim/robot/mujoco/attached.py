"""One sensor attached to a model: it solves where the body is, answers linearly in between, and takes frames.

Wrenches are (force [N], torque [N mm]) on the sensor about its origin in its frame; motions are (shift [mm], rotation
[rad]) of the object's point at the sensor's origin.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.pose import Pose
from magicsim.robot.darkroom import Darkroom, Moment
from magicsim.robot.mujoco.pair import Touch, check_excluded, find_pair
from magicsim.robot.mujoco.posed import AXES, PosedSensor, PosedState, facing_distance_mm, posed_state
from magicsim.robot.mujoco.solids import MM, MjData, MjModel, body_object, engine, pose_in_sensor
from magicsim.robot.quality import Quality
from magicsim.scenes.scene import Keyframe, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, with_passing
from magicsim.simulation.episode import SimulatedFrame
from magicsim.simulation.sensor import Sensor

LEAST_MM, MOST_MM = 0.005, 0.3
"""Shortest and longest way between two solves [mm]."""
SAFETY, SLOWEST, FASTEST = 0.9, 0.5, 1.5
"""Part of the way that the error allows which is gone, and the least and largest change of it from solve to solve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trust:
    """Way between solves, learned from the errors of the linear answers.

    The error of a linear answer grows with the square of the way, so the way that would have met the tolerance is the
    present one times the root of tolerance over error, as step sizes of differential equations are chosen.
    """

    tolerance_n: float
    """Error of the predicted force that is aimed at [N]."""
    way_mm: float = 0.05
    """Way after which the contact is solved again [mm]."""
    worst_n: float = 0.0
    """Largest error so far [N]."""

    def learned(self, error_n: float) -> Self:
        """After a prediction turned out to be wrong by so much [N]."""
        wanted = SAFETY * math.sqrt(self.tolerance_n / max(error_n, 1e-12))
        way = self.way_mm * min(max(wanted, SLOWEST), FASTEST)
        return replace(self, way_mm=min(max(way, LEAST_MM), MOST_MM), worst_n=max(self.worst_n, error_n))


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """A solved equilibrium and its tangent."""

    pose: Pose
    """Pose of the object when it was solved."""
    wrench: Array
    """Shape (6,)."""
    tangent: Array
    """Derivative of the wrench by the motion, shape (6, 6)."""
    centre_mm: Array
    """Middle of the contact, shape (3,) [mm]."""
    radius_mm: float
    """Radius of a circle of the contact's area [mm]."""

    @classmethod
    def of(cls, pose: Pose, deformation: Deformation, tangent: Array) -> "Response":
        """From a deformation."""
        pressure = deformation.contact_pressure_mpa
        total = float(pressure.sum())
        centre = pressure @ deformation.contact_points_mm / total if total > 0 else np.zeros(3)
        return cls(
            pose=pose, wrench=np.concatenate([deformation.force_n, deformation.torque_nmm]), tangent=tangent,
            centre_mm=centre, radius_mm=float(np.sqrt(deformation.contact_area_mm2 / np.pi)),
        )  # fmt: skip

    def motion(self, pose: Pose) -> Array:
        """The object's motion since the solve, shape (6,)."""
        turn = pose.rotation @ self.pose.rotation.T
        shift = pose.position_mm - turn @ self.pose.position_mm
        return np.concatenate([shift, Rotation.from_matrix(turn).as_rotvec()])

    def way_mm(self, pose: Pose) -> float:
        """How far the object has moved at the contact since the solve [mm]."""
        motion = self.motion(pose)
        shift = motion[:3] + np.cross(motion[3:], self.centre_mm)
        return float(np.linalg.norm(shift) + self.radius_mm * np.linalg.norm(motion[3:]))

    def predicted(self, pose: Pose) -> Array:
        """The wrench in another pose, shape (6,); zero where the sensor would have to pull."""
        wrench = self.wrench + self.tangent @ self.motion(pose)
        return wrench if wrench[2] > 0 else np.zeros(6)

    @property
    def stiffness(self) -> Array:
        """The symmetric part of the tangent without its negative directions, shape (6, 6)."""
        values, vectors = np.linalg.eigh((self.tangent + self.tangent.T) / 2)
        return np.asarray((vectors * np.maximum(values, 0)) @ vectors.T)


class AttachedSensor:
    """A sensor at a site that touches one body of the model."""

    def __init__(
        self, model: MjModel, touch: Touch, scene: SceneConfig, *, quality: Quality, trust: Trust, seed: int,
        opposite: Callable[[], Sensor | None],
    ) -> None:  # fmt: skip
        """Builds the sensor with the body's solid as its object; `trust` is that of the first linear answer.

        Raises:
            ConfigError: A name does not exist, the body cannot press, or MuJoCo would press it too.
            MagicsimError: The sensor cannot be built.
        """
        if (memory := scene.contact.memory) is not None:
            raise ConfigError(f"{memory} is not allowed here: the sensor is solved quasi-statically and elastic")
        self.touch, self.pair = touch, find_pair(model, touch)
        check_excluded(model, touch, self.pair)
        thing, self._frame = body_object(model, self.pair.body)
        bare = scene.model_copy(update={"object": None, "keyframes": (Keyframe(frame=0),)})
        settled = quality.applied(bare)
        self.sensor = PosedSensor(settled, thing, x_mm=touch.x_mm, y_mm=touch.y_mm, opposite=opposite)
        self._thing, self._darkroom = thing, Darkroom(self.sensor, settled.output)
        self._first_trust = trust
        self._moment = Moment(
            seed=seed, index=0, time_s=0.0, frames_per_second=settled.frames_per_second, deformation=self.sensor.rest
        )
        self.reset()

    def reset(self) -> None:
        """The untouched sensor at the beginning of its stream."""
        self.state: FrameState = UNTOUCHED
        self.deformation = self.sensor.rest
        self.response: Response | None = None
        """The last solve; None while nothing is near."""
        self.trust, self.solves = self._first_trust, 0
        self._moment = replace(self._moment, index=0, memory=None)
        self._facing_mm: float | None = None

    def pose(self, data: MjData) -> Pose:
        """Where the object is in the sensor's frame."""
        return pose_in_sensor(data, self.pair.body, self._frame, self.pair.site)

    def motion_rows(self, model: MjModel, data: MjData) -> Array:
        """Jacobian of the object's motion against the sensor at the sensor's origin, shape (6, dofs) [mm, rad]."""
        site = self.pair.site
        point, turn = np.array(data.site_xpos[site]), data.site_xmat[site].reshape(AXES, AXES)
        rows = []
        for body in (self.pair.body, self.pair.finger):
            shift, rotation = np.zeros((AXES, model.nv)), np.zeros((AXES, model.nv))
            engine().mj_jac(model, data, shift, rotation, point, body)
            rows.append(np.concatenate([MM * turn.T @ shift, turn.T @ rotation]))
        return np.asarray(rows[0] - rows[1])

    def needs_solve(self, pose: Pose) -> bool:
        """Whether the object has moved farther since the last solve than its answer is trusted."""
        state = posed_state(self._thing, pose)
        if not state.can_touch:
            return self.response is not None
        return self.response is None or self.response.way_mm(pose) > self.trust.way_mm

    def solve(self, pose: Pose) -> None:
        """Finds the equilibrium with the object in a pose (`ConvergenceError` without one), and its tangent."""
        state = posed_state(self._thing, pose)
        self.state = state
        if not (state.can_touch and isinstance(state, PosedState)):
            self.deformation, self.response = self.sensor.rest, None
            return
        predicted = self.response.predicted(pose) if self.response is not None else None
        try:
            self.deformation = self.sensor.deform(state, self.deformation)
        except ConvergenceError as error:
            msg = f"body '{self.touch.body}' on site '{self.touch.site}', gap {state.gap_mm:.3g} mm: {error}"
            raise ConvergenceError(msg) from None
        self.solves += 1
        self.response = Response.of(pose, self.deformation, self.sensor.tangent(state, self.deformation))
        if predicted is not None and (predicted.any() or self.response.wrench.any()):  # nothing is learned of no touch
            error_n = float(np.linalg.norm(predicted[:AXES] - self.response.wrench[:AXES]))
            self.trust = self.trust.learned(error_n)

    def wrench(self, pose: Pose) -> Array:
        """Elastic wrench of the object on the sensor about its origin in its frame, shape (6,) [N, N mm]."""
        return self.response.predicted(pose) if self.response is not None else np.zeros(6)

    def face(self, data: MjData, other: "AttachedSensor") -> None:
        """Looks at another sensor where both are now; `ConfigError` where they do not face each other."""
        names = self.touch.site, other.touch.site
        self._facing_mm = facing_distance_mm(data, self.pair.site, other.pair.site, names)

    def grab(self, time_s: float) -> Moment:
        """The moment of the next frame, as last solved."""
        state = replace(self.state, facing_mm=self._facing_mm)
        state = with_passing(state, self.sensor.rig, time_s=time_s, seed=self._moment.seed)
        moment = replace(self._moment, time_s=time_s, state=state, deformation=self.deformation)
        memory = self._darkroom.passed(moment) if self.sensor.rig.camera.history else None
        self._moment = replace(moment, index=moment.index + 1, memory=memory)
        return moment

    def develop(self, moment: Moment) -> SimulatedFrame:
        """Renders a moment; `RenderError` where the image is not valid."""
        return self._darkroom.develop(moment)
