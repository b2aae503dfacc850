"""The MagicGripper's two facing sensors with one object between them: they close, hold it, and may lose it.

Frames are those of `magicsim.robot.fingers`. Each finger is solved and rendered by itself from the one place of the
object; each sees the other one behind the object (`magicsim.light.facing`).
"""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import SIDES, ObjectPlace, finger_pose, half_extents_mm, seen_by_lower
from magicsim.robot.grip.held import settle
from magicsim.robot.grip.linkage import Linkage, close_until
from magicsim.robot.grip.load import SLIPPED_MM, Hold, Load
from magicsim.robot.grip.pair import FingerPair, finger_seed, float_between
from magicsim.robot.grip.truth import GripFrames, GripMoment, GripState, GripTruth, grip_truth
from magicsim.robot.live import LEAST_WIDTH_MM, MAX_SEED, LiveSensor, still_to_come
from magicsim.robot.quality import Quality
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig
from magicsim.waiting import Told, on_stderr, waiting

TILT_DEG = 15.0
"""How far an object may tilt in a gripper whose workspace is not given [degrees]."""
WHERE = {Hold.DROPPED: "dropped", Hold.AWAY: "been taken away"}
MOST_SLIDE_MM = 3.0
"""Way of the object in one motion beyond which no friction will hold it any more [mm]; assumed."""


class Gripper(AbstractContextManager["Gripper"]):
    """Two fingers that close on one object, moved by the caller; motions are quasi-static, as in `LiveSensor`.

    The object is either placed by the caller (`close`), as by a hand, or held by the fingers alone (`hold`): then its
    place is where both contacts, its weight and whatever else pulls are in balance, and where there is no such place it
    drops.
    """

    def __init__(
        self, scene: SceneConfig, *, workspace: Workspace | None = None, lower: SceneConfig | None = None,
        linkage: Linkage | None = None, quality: str | Quality = "full", sees_other: bool = True,
        companion: SurfaceMesh | None = None, within_limits: bool = False, told: Told = on_stderr,
    ) -> None:  # fmt: skip
        """Builds both fingers.

        Args:
            scene: Design, rig, contact and render settings of the fingers, and the object in the gripper's frame.
            workspace: Where the object may go; x, y, twist and tilts in the gripper's frame, the gap each finger's.
            lower: Another design or rig for the lower finger, radiances of both in one unit; by default the same, with
                a camera of its own fixed pattern.
            linkage: What moves the fingers.
            quality: `full`, or `control` for coarser and faster sensors, see `magicsim.robot.quality`.
            sees_other: Whether each finger is in the other's picture.
            companion: What both see beside the object where `accompany` puts it, with colours, in its own frame, such
                as a hand; it touches nothing. Needs `sees_other`.
            within_limits: Whether a motion that would end beyond the limits of a finger's design is an error, after
                which everything stays as it was; by default the first one is a warning.
            told: Hears what takes longer than two seconds; it is written to stderr by default.

        Raises:
            ConfigError: There is no object, it does not fit between the open fingers, or the workspace goes too deep.
            MagicsimError: A finger cannot be built.
        """
        if scene.object is None:
            raise ConfigError("object is missing: a gripper needs one between its fingers")
        if companion is not None and not sees_other:
            raise ConfigError("companion is not allowed with sees_other = False: it is drawn with the other finger")
        workspace = workspace or Workspace(tilt_x_deg=(-TILT_DEG, TILT_DEG), tilt_y_deg=(-TILT_DEG, TILT_DEG))
        self.linkage = linkage or Linkage()
        self.linkage.check_room(scene.object.kind, sum(half_extents_mm(scene.object)))
        self._told, self._within_limits, self._inside = told, within_limits, False
        with waiting("building both fingers", told):
            unlike = lower is not None
            self.upper = LiveSensor(
                scene, workspace=workspace, quality=quality, companion=companion, told=told,
                opposite=(lambda: self.lower.sensor) if unlike else None,
            )  # fmt: skip
            facing = {"object": seen_by_lower(scene.object)}
            self.lower = LiveSensor(
                (lower or _with_next_pattern(scene)).model_copy(update=facing), workspace=_facing_range(workspace),
                quality=quality, companion=companion, told=told,
                opposite=(lambda: self.upper.sensor) if unlike else None,
            )  # fmt: skip
            self._pair = FingerPair(self.upper, self.lower, scene.object, sees_other=sees_other)
            self._reaches_mm = self._pair.reaches_mm(ObjectPlace())
            self._state = GripState(width_mm=self._open_mm, place=self._midway)
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
        for number, finger in enumerate(self.fingers):
            finger.reset(seed=finger_seed(seed, number))
        self.close(self._open_mm, place=self._midway)

    @property
    def _midway(self) -> ObjectPlace:
        """Where the object is as far from either finger."""
        up, down = self._reaches_mm
        return ObjectPlace(z_mm=(down - up) / 2)

    @property
    def _open_mm(self) -> float:
        """Where both fingers start: as far from an object in the middle as workspace and linkage allow [mm]."""
        far = self.touching_width_mm + 2 * self.upper.workspace.gap_mm[1]
        return min(far, self.linkage.width_mm(self.linkage.most_deg))

    @property
    def fingers(self) -> tuple[LiveSensor, LiveSensor]:
        """Upper and lower."""
        return self.upper, self.lower

    @property
    def width_mm(self) -> float:
        """Distance between the contact faces at rest [mm]."""
        return self._state.width_mm

    @property
    def angle_deg(self) -> float:
        """Angle of the cranks, see `Linkage` [degrees]."""
        return self.linkage.angle_deg(self.width_mm)

    @property
    def place(self) -> ObjectPlace:
        """Where the object is."""
        return self._state.place

    @property
    def outcome(self) -> Hold:
        """What became of the object in the last motion."""
        return self._state.hold

    @property
    def has_companion(self) -> bool:
        """Whether the gripper was built with something that `accompany` can put beside the object."""
        return self.upper.sensor.companion is not None

    @property
    def touching_width_mm(self) -> float:
        """Distance between the faces at which both just touch the object in the middle, not tilted [mm]."""
        return sum(self._reaches_mm)

    def close(self, width_mm: float, *, place: ObjectPlace | None = None, floats: bool = False) -> None:
        """Brings the faces to a distance, the object to a place; either finger's indentation follows from geometry.

        Args:
            width_mm: Distance between the contact faces at rest [mm].
            place: Where the object goes; where it was, by default the middle.
            floats: Whether the object moves along the closing axis until the normal forces of both fingers are equal,
                from `place.z_mm`; its own weight and rotation are left out.

        Raises:
            ConfigError: The object would leave a finger's workspace, or the fingers their range.
            ConvergenceError: No valid equilibrium was found; both fingers stay where they were.
        """
        self._check_width(width_mm)
        asked = place or self.place
        with self._whole("moving the fingers"), self._motion():
            if floats:
                asked = float_between(self._pair, asked, width_mm)
            else:
                self._pair.put(asked, width_mm)
            self._state = GripState(width_mm=width_mm, place=asked)

    def hold(
        self, width_mm: float | None = None, *, load: Load | None = None, most_slide_mm: float = MOST_SLIDE_MM
    ) -> Hold:
        """Brings the faces to a distance and lets go of the object: it rests where fingers and load hold it, or drops.

        The balance is that of all three forces and three torques, with Coulomb's friction at both faces. An object that
        is driven on where the workspace ends is not followed any farther: it counts as dropped, and `GripTruth.limit`
        names the coordinate; one without any range is held by its guide. Weight and outer wrench act at once. After a
        drop the fingers are empty until `close` puts the object between them again.

        Args:
            width_mm: Distance between the contact faces at rest; as it is by default [mm].
            load: What acts on the object; what acted before by default.
            most_slide_mm: Way of the object in this motion beyond which it counts as dropped [mm].

        Returns:
            Whether it is held, held after a slip, or dropped.

        Raises:
            ConfigError: The object does not fit, the fingers would leave their range, or there is no object any more.
            ConvergenceError: No valid equilibrium of a finger was found; everything stays as it was.
        """
        width = self.width_mm if width_mm is None else width_mm
        self._check_width(width)
        check_number("most_slide_mm", most_slide_mm, 0.01, 100)
        if self.outcome.is_empty:
            raise ConfigError(
                f"hold is not allowed: the object has {WHERE[self.outcome]}; put it between the fingers with "
                "close(width, place=...)"
            )
        acting = self._state.load if load is None else load
        with self._whole("finding where the object rests"), self._motion():
            self._state = settle(self._pair, self.place, width, acting, most_slide_mm=most_slide_mm)
        return self.outcome

    def remove_object(self) -> None:
        """Takes the object away; the fingers stay where they are, and `close` puts it between them again."""
        with self._whole("taking the object away"):
            self._pair.take_away(self.width_mm)
            self._state = GripState(width_mm=self.width_mm, place=self.place, hold=Hold.AWAY)

    def accompany(self, pose: Pose | None) -> None:
        """Puts what is seen beside the object somewhere until the object is removed, or takes it away.

        Args:
            pose: From its own frame to the gripper's, as the fingers stand now; None takes it away.

        Raises:
            ConfigError: The gripper was built without a companion.
        """
        with self._whole("placing what is seen beside the object"):
            for side, finger in zip(SIDES, self.fingers, strict=True):
                finger.accompany(None if pose is None else pose.seen_from(finger_pose(side, self.width_mm)))

    def turn_to(self, angle_deg: float, *, dt_s: float, load: Load | None = None, floats: bool = False) -> Hold:
        """Turns the cranks towards an angle for some time, no faster than they can, and stops where the motors stall.

        An object that is held (`load` is given, or it was held before) goes along with the fingertips on their arcs;
        one that is placed stays where it is in the room, so that the tips move along it.

        Args:
            angle_deg: Where to; beyond the linkage's range its end counts.
            dt_s: Time [s].
            load: What acts on the object if only the fingers hold it from now on.
            floats: Whether one that is placed gives way along the closing axis, see `close`.

        Returns:
            What became of the object.

        Raises:
            ConfigError: The object does not fit, or would leave a finger's workspace.
            ConvergenceError: No valid equilibrium was found; everything stays as it was.
        """
        check_number("dt_s", dt_s, 0, 1e3)
        check_number("angle_deg", angle_deg, -360, 360)
        target = self.linkage.width_mm(self.linkage.turned_deg(self.angle_deg, angle_deg, dt_s=dt_s))
        acting = load if load is not None or self.outcome is Hold.PLACED else self._state.load
        with self._whole("turning the cranks"), self._motion():
            is_stalled = self._close_to(target, acting, floats=floats)
            self._state = replace(self._state, is_stalled=is_stalled)
        return self.outcome

    def now(self) -> GripMoment:
        """The present moment of fingers and object, for `go_back`."""
        return GripMoment(fingers=self._pair.moments(), state=self._state)

    def go_back(self, moment: GripMoment) -> None:
        """Fingers, object and the history of both contacts as they were at a moment; the streams go on."""
        self._pair.go_back(moment.fingers)
        self._state = moment.state

    def truth(self) -> GripTruth:
        """Truth of the present state."""
        return grip_truth(self._state, self.upper.truth, self.lower.truth, angle_deg=self.angle_deg)

    def frames(self) -> GripFrames:
        """The next frame of both fingers, with their common truth."""
        angle = self.angle_deg
        with waiting("rendering both fingers", self._told), still_to_come(*self.fingers):
            moments = self.upper.grab(), self.lower.grab()
            upper, lower = self.upper.develop(moments[0]), self.lower.develop(moments[1])
            truth = grip_truth(self._state, upper.truth, lower.truth, angle_deg=angle)
            return GripFrames(upper=upper, lower=lower, truth=truth)

    def release(self) -> None:
        """Lets go of both sensors; may be called again."""
        self.upper.close()
        self.lower.close()

    def __exit__(self, *_: object) -> None:
        self.release()

    @contextmanager
    def _whole(self, doing: str) -> Iterator[None]:
        """All of what is done with both fingers, or nothing where it fails or is interrupted.

        What it ends with is held against the limits of the designs; not what is tried on the way.
        """
        before, is_inner = self.now(), self._inside
        self._inside = True
        try:
            with waiting(doing, self._told):
                yield
            for finger in () if is_inner else self.fingers:
                excess = finger.truth.beyond_limits
                if excess and self._within_limits:
                    raise ConfigError(f"a motion is not allowed with within_limits: {excess}")
                finger.sensor.limits.see(excess)
        except BaseException:
            self.go_back(before)
            raise
        finally:
            self._inside = is_inner

    @contextmanager
    def _motion(self) -> Iterator[None]:
        """One motion, of any number of steps: tells how far the skin slid in all of it, and whether that is a slip."""
        before = self._pair.slid_mm
        yield
        way = max(now - then for now, then in zip(self._pair.slid_mm, before, strict=True))
        hold = self.outcome
        if hold in {Hold.HELD, Hold.SLIPPED}:
            hold = Hold.SLIPPED if way > SLIPPED_MM else Hold.HELD
        self._state = replace(self._state, slid_mm=way, hold=hold)

    def _close_to(self, width_mm: float, load: Load | None, *, floats: bool) -> bool:
        """Turns the cranks until the faces are so far apart, or the motors stall: says whether they did."""
        start = self.width_mm
        if width_mm >= start or self.outcome.is_empty:
            self._go(self.linkage.angle_deg(width_mm), load, floats=floats)
            return False
        base = [self.now()]

        def force_n(width: float) -> float:
            self.go_back(base[0])
            self._go(self.linkage.angle_deg(width), load, floats=floats)
            return self._pair.normal_n

        def keep() -> None:
            base[0] = self.now()

        touching, closest = self._pair.closing_mm(self.place, floats=floats or load is not None)
        first, last = min(start, max(touching, width_mm)), max(width_mm, closest)
        if first < start:
            force_n(first)
            keep()
        stands = first, self._pair.normal_n
        is_stalled = close_until(force_n, keep, stands, min(first, last), self.linkage.force_limit_n)
        if not is_stalled and width_mm < last:
            force_n(width_mm)  # refused by the workspace: the motors were stronger than it is deep
        return is_stalled

    def _go(self, angle_deg: float, load: Load | None, *, floats: bool) -> None:
        """Turns the cranks at once, the object held under a load, or staying where it is in the room."""
        width, along = self.linkage.width_mm(angle_deg), self.linkage.along_mm(self.angle_deg)
        if self.outcome.is_empty:
            self._pair.face(width)
            self._state = replace(self._state, width_mm=width, is_stalled=False)
        elif load is not None:
            self.hold(width, load=load)
        else:
            rise = self.linkage.along_mm(angle_deg) - along
            self.close(width, place=replace(self.place, y_mm=self.place.y_mm - rise), floats=floats)

    def _check_width(self, width_mm: float) -> None:
        if width_mm < LEAST_WIDTH_MM:
            msg = f"width_mm = {width_mm:g} is not allowed: the fingers would pass through each other, must be above 0"
            raise ConfigError(msg)
        self.linkage.check(width_mm)


def _facing_range(workspace: Workspace) -> Workspace:
    (x_low, x_high), (first, last), (back, forth) = workspace.x_mm, workspace.twist_deg, workspace.tilt_x_deg
    return replace(workspace, x_mm=(-x_high, -x_low), twist_deg=(-last, -first), tilt_x_deg=(-forth, -back))


def _with_next_pattern(scene: SceneConfig) -> SceneConfig:
    camera = scene.rig.camera
    update = {"camera": camera.model_copy(update={"pattern_seed": (camera.pattern_seed + 1) % 2**31})}
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=update)})
