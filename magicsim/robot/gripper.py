"""The MagicGripper's two facing sensors with one object between them: parallel closing, frames and truth in pairs.

Frames are those of `magicsim.robot.fingers`. Each finger is solved and rendered by itself from the one place of the
object: neither sees the other's light through the object, and past it the other finger is not in its picture.
"""

from dataclasses import dataclass, replace
from types import TracebackType
from typing import Self

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from magicsim.config.ranges import check_number
from magicsim.deform.indentation.path_force import as_vector
from magicsim.errors import ConfigError, MagicsimError
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.robot.fingers import SIDES, ObjectPlace, Side, finger_motion, finger_pose, half_extents_mm, seen_by
from magicsim.robot.live import MAX_SEED, LiveSensor
from magicsim.robot.moment import Moment
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig
from magicsim.simulation.episode import FrameTruth, SimulatedFrame, Vector

Array = npt.NDArray[np.float64]
BALANCE_N = 0.01
"""Difference of the two normal forces at which a floating object rests [N]."""
FINEST_MM = 1e-6
"""Interval of places at which the search for balance ends in any case [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GripTruth:
    """What is true of both fingers and the object at once, in the gripper's frame."""

    width_mm: float
    """Distance between the contact faces at rest [mm]."""
    place: ObjectPlace
    """The object."""
    force_n: Vector
    """Force of both fingers on the object [N]."""
    torque_nmm: Vector
    """Their torque on it about its origin [N mm]."""
    imbalance_n: float
    """Normal force of the upper finger less that of the lower [N]; what is left of it where the object floats."""
    upper: FrameTruth
    """The upper finger's, in its own frame."""
    lower: FrameTruth
    """The lower finger's, in its own frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GripFrames:
    """One frame of each finger, taken at the same moment."""

    upper: SimulatedFrame
    lower: SimulatedFrame
    truth: GripTruth


class Gripper:
    """Two fingers that close on one object, moved by the caller; motions are quasi-static, as in `LiveSensor`."""

    def __init__(
        self, scene: SceneConfig, *, workspace: Workspace | None = None, lower: SceneConfig | None = None
    ) -> None:
        """Builds both fingers.

        Args:
            scene: Design, rig, contact and render settings of the fingers, and the object in the gripper's frame.
            workspace: Where the object may go, x, y and twist in the gripper's frame; the gap is each finger's.
            lower: Another design or rig for the lower finger; by default the same, with a camera of its own fixed
                pattern.

        Raises:
            ConfigError: There is no object, or the workspace goes too deep.
            MagicsimError: A finger cannot be built.
        """
        if scene.object is None:
            msg = "object is missing: a gripper needs one between its fingers"
            raise ConfigError(msg)
        workspace = workspace or Workspace()
        self._extents_mm = half_extents_mm(scene.object)
        self.upper = LiveSensor(scene, workspace=workspace)
        facing = _facing(lower or _with_next_pattern(scene), scene.object)
        self.lower = LiveSensor(facing, workspace=_facing_range(workspace))
        self._width_mm, self._place = self._open_mm, ObjectPlace()
        self.reset()

    def reset(self, *, seed: int | None = None) -> None:
        """Fingers open and far from the object, at full light, their streams at the first frame.

        Args:
            seed: Of the frames' noise, of which each finger has its own; the scene's by default.

        Raises:
            ConfigError: The seed is not allowed.
        """
        seed = self.upper.sensor.seed if seed is None else seed
        check_number("seed", seed, 0, MAX_SEED - 1, whole=True)
        for number, finger in enumerate((self.upper, self.lower)):
            finger.reset(seed=finger_seed(seed, number))
        self.close(self._open_mm, place=ObjectPlace())

    @property
    def _open_mm(self) -> float:
        """Where both fingers start: as far from an object in the middle as the workspace allows [mm]."""
        return self.touching_width_mm + 2 * self.upper.workspace.gap_mm[1]

    @property
    def width_mm(self) -> float:
        """Distance between the contact faces at rest [mm]."""
        return self._width_mm

    @property
    def place(self) -> ObjectPlace:
        """Where the object is."""
        return self._place

    @property
    def touching_width_mm(self) -> float:
        """Distance between the faces at which both just touch the object [mm]."""
        return sum(self._extents_mm)

    def close(self, width_mm: float, *, place: ObjectPlace | None = None, floats: bool = False) -> None:
        """Brings the faces to a distance, the object to a place; either finger's indentation follows from geometry.

        Args:
            width_mm: Distance between the contact faces at rest [mm].
            place: Where the object goes; where it was, by default the middle.
            floats: Whether the object moves along the closing axis until the normal forces of both fingers are equal,
                from `place.z_mm`; its own weight and rotation are left out.

        Raises:
            ConfigError: The object would leave a finger's workspace.
            ConvergenceError: No valid equilibrium was found; both fingers stay where they were.
        """
        before, asked = (self.upper.now(), self.lower.now()), place or self._place
        try:
            settled = self._floating(asked, width_mm) if floats else self._at(asked, width_mm)
        except MagicsimError:
            self._go_back(before)
            raise
        self._width_mm, self._place = width_mm, settled

    def truth(self) -> GripTruth:
        """Truth of the present state."""
        return self._truth(self.upper.truth, self.lower.truth)

    def frames(self) -> GripFrames:
        """The next frame of both fingers, with their common truth."""
        moments = self.upper.grab(), self.lower.grab()
        upper, lower = self.upper.develop(moments[0]), self.lower.develop(moments[1])
        return GripFrames(upper=upper, lower=lower, truth=self._truth(upper.truth, lower.truth))

    def release(self) -> None:
        """Lets go of both sensors; may be called again."""
        self.upper.close()
        self.lower.close()

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Releases."""
        self.release()

    def _at(self, place: ObjectPlace, width_mm: float) -> ObjectPlace:
        for side, finger in zip(SIDES, (self.upper, self.lower), strict=True):
            finger.move_to(**finger_motion(side, place, width_mm, self._extents_mm))
        return place

    def _floating(self, place: ObjectPlace, width_mm: float) -> ObjectPlace:
        up, down = self._extents_mm
        touches_upper, touches_lower = width_mm / 2 - up, down - width_mm / 2
        if touches_lower <= touches_upper:  # room for the object: a finger that touches it pushes it away
            return self._at(replace(place, z_mm=min(max(place.z_mm, touches_lower), touches_upper)), width_mm)
        before = self.upper.now(), self.lower.now()
        deepest = -self.upper.workspace.gap_mm[0]
        low, high = max(touches_upper, touches_lower - deepest), min(touches_lower, touches_upper + deepest)
        tried: dict[float, tuple[float, tuple[Moment, Moment]]] = {}

        def imbalance_n(z_mm: float) -> float:
            """Difference of the normal forces with the object at a place, 0 where they balance; fingers stay there."""
            if z_mm not in tried:
                self._go_back(before)
                self._at(replace(place, z_mm=z_mm), width_mm)
                found = self._imbalance_n()
                tried[z_mm] = (0.0 if abs(found) <= BALANCE_N else found, (self.upper.now(), self.lower.now()))
            value, moments = tried[z_mm]
            self._go_back(moments)
            return value

        settled = (low + high) / 2
        at_middle = imbalance_n(settled)
        if at_middle != 0:
            ends = (low, settled) if at_middle > 0 else (settled, high)
            if imbalance_n(ends[0]) < 0 < imbalance_n(ends[1]):
                settled = float(brentq(imbalance_n, *ends, xtol=FINEST_MM))
            else:  # as near to balance as the workspace lets it come
                settled = ends[0] if at_middle > 0 else ends[1]
            imbalance_n(settled)
        return replace(place, z_mm=settled)

    def _go_back(self, moments: tuple[Moment, Moment]) -> None:
        for finger, moment in zip((self.upper, self.lower), moments, strict=True):
            finger.go_back(moment)

    def _imbalance_n(self) -> float:
        return float(self.upper.deformation.force_n[2] - self.lower.deformation.force_n[2])

    def _truth(self, upper: FrameTruth, lower: FrameTruth) -> GripTruth:
        place, force, torque = self._place, np.zeros(3), np.zeros(3)
        origin = np.array([place.x_mm, place.y_mm, place.z_mm])
        sides: tuple[tuple[Side, FrameTruth], ...] = (("upper", upper), ("lower", lower))
        for side, truth in sides:
            pose = finger_pose(side, self._width_mm)
            acting = -pose.rotation @ np.array(truth.force_n)
            force += acting
            torque += np.cross(pose.position_mm - origin, acting) - pose.rotation @ np.array(truth.torque_nmm)
        return GripTruth(
            width_mm=self._width_mm,
            place=place,
            force_n=as_vector(force),
            torque_nmm=as_vector(torque),
            imbalance_n=upper.force_n[2] - lower.force_n[2],
            upper=upper,
            lower=lower,
        )


def finger_seed(seed: int, number: int) -> int:
    """The seed of one finger's noise, from the gripper's and the finger's number."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0] >> 1)


def _facing(scene: SceneConfig, target: AnyObject) -> SceneConfig:
    return scene.model_copy(update={"object": seen_by("lower", target)})


def _facing_range(workspace: Workspace) -> Workspace:
    low, high = workspace.x_mm
    first, last = workspace.twist_deg
    return replace(workspace, x_mm=(-high, -low), twist_deg=(-last, -first))


def _with_next_pattern(scene: SceneConfig) -> SceneConfig:
    camera = scene.rig.camera
    update = {"camera": camera.model_copy(update={"pattern_seed": (camera.pattern_seed + 1) % 2**31})}
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=update)})
