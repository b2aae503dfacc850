"""A sensor whose object comes in any pose, not only in those that a path of gap, shift and twist reaches."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.zone import BLUNT, Zone
from magicsim.errors import ConfigError
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import TO_GRIPPER
from magicsim.robot.live import LEAST_WIDTH_MM
from magicsim.robot.mujoco.solids import MM, BodyObject, MjData
from magicsim.robot.workspace import Range
from magicsim.scenes.rig import FARTHEST_MM
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

MOST_TURN_DEG, MOST_ASIDE_MM = 5.0, 2.0
"""How far from face to face two sensors may stand that are drawn so, half a turn about y apart."""
AXES = 3


def facing_distance_mm(data: MjData, own: int, other: int, names: tuple[str, str]) -> float:
    """Distance of the contact faces of two sensors [mm]; `ConfigError` where they do not face each other."""
    turn, facing = (np.asarray(data.site_xmat[site], float).reshape(AXES, AXES) for site in (own, other))
    apart: Array = MM * turn.T @ (data.site_xpos[other] - data.site_xpos[own])
    between = TO_GRIPPER["lower"] @ turn.T @ facing
    turned = float(np.degrees(np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))))
    aside, distance = float(np.hypot(apart[0], apart[1])), -float(apart[2])
    if turned > MOST_TURN_DEG or aside > MOST_ASIDE_MM or not LEAST_WIDTH_MM <= distance <= FARTHEST_MM:
        raise ConfigError(
            f"site '{names[0]}' does not face site '{names[1]}' at {data.time:.3f} s: {turned:.3g} degrees from half a "
            f"turn about y, {aside:.3g} mm aside, {distance:.3g} mm apart; must be at most {MOST_TURN_DEG:g} degrees "
            f"and {MOST_ASIDE_MM:g} mm, {LEAST_WIDTH_MM:g} to {FARTHEST_MM:g} mm apart"
        )
    return distance


@dataclass(frozen=True, slots=True, kw_only=True)
class PosedState(FrameState):
    """A frame's state with the object in a pose of its own; gap, shift and twist are read off it."""

    pose: tuple[float, ...]
    """The object's pose in the sensor's frame, see `Pose.key`."""


def posed_state(thing: BodyObject, pose: Pose) -> FrameState:
    """The state of a frame with the object in a pose; without one where it is behind the face or too far away."""
    solid, up = thing.shape(), pose.rotation[2]
    x, y, z = pose.position_mm.tolist()
    gap = -(z + solid.support_mm(up))
    is_behind = z - solid.support_mm(-up) >= 0
    if is_behind or max(abs(x), abs(y), gap) > FARTHEST_MM:
        return UNTOUCHED
    twist = math.degrees(math.atan2(pose.rotation[1, 0], pose.rotation[0, 0]))
    return PosedState(gap_mm=gap, x_mm=x, y_mm=y, twist_deg=twist, flashlight=False, light_x_mm=0.0, pose=pose.key())


class PosedSensor(Sensor):
    """A sensor of a scene with another object, fine on a declared part of its face."""

    def __init__(
        self, scene: SceneConfig, thing: BodyObject, *, x_mm: Range, y_mm: Range,
        opposite: Callable[[], Sensor | None],
    ) -> None:  # fmt: skip
        """Builds the sensor, fine where the object may touch; `opposite` as for `Sensor`."""
        feature = thing.shape().feature_mm
        zone = Zone(low_mm=(x_mm[0], y_mm[0]), high_mm=(x_mm[1], y_mm[1]), feature_mm=feature)
        self._declared = replace(zone, is_blunt=feature > BLUNT * zone.radius_mm)
        self._thing = thing
        super().__init__(
            scene.design, scene.rig, thing, contact=scene.contact, render=scene.render, seed=scene.seed,
            step_s=1 / scene.frames_per_second, opposite=opposite,
        )  # fmt: skip

    def _zone(self) -> Zone:
        return self._declared

    def indenter(self, state: FrameState) -> Indenter | None:
        """The object as placed by a state."""
        if not isinstance(state, PosedState):
            return super().indenter(state)
        pose = Pose.from_key(state.pose)
        return Indenter(shape=self._thing.entered(pose), pose=pose)

    def tangent(self, state: FrameState, deformation: Deformation) -> Array:
        """How force and torque change with the object's motion, shape (6, 6), see `magicsim.deform.solve.tangent`.

        Zero at rest, and where it cannot be worked out.
        """
        indenter = self.indenter(state)
        if self._solver is None or indenter is None or deformation.is_rest:
            return np.zeros((6, 6))
        found = self._solver.tangent(deformation, indenter)
        return np.zeros((6, 6)) if found is None else found
