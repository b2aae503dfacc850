"""A simulated sensor whose object and lights the user's code moves, in any order, one frame at a time."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from magicsim.camera.effect_settings import H264
from magicsim.config.ranges import check_number
from magicsim.deform.contact.face import contact_face, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.pose import Pose
from magicsim.robot.darkroom import Darkroom, Moment
from magicsim.robot.quality import Quality, find_quality
from magicsim.robot.workspace import RANGES, Workspace, slip_share, travel
from magicsim.scenes.rig import FARTHEST_MM
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, with_passing
from magicsim.simulation.episode import FrameTruth, SimulatedFrame
from magicsim.simulation.sensor import Sensor
from magicsim.waiting import Told, on_stderr, waiting

MAX_SEED = 2**31
MIN_FRAME_RATE, MAX_FRAME_RATE = 0.001, 1000
FIRST_PICTURE, PICTURE = "rendering the untouched sensor and a frame", "rendering a frame"
LEAST_WIDTH_MM = 0.01
"""Least distance of facing contact faces: fingers do not pass through each other [mm]."""
STRONGEST = 1000.0
"""Strength of the LEDs, in units of the rig's radiance."""


class LiveSensor(AbstractContextManager["LiveSensor"]):
    """One sensor with one object, moved by the caller.

    Every motion is quasi-static and starts from the equilibrium before, so friction has the history of the motions. A
    motion that fails leaves everything as it was. Exposure is metered once, on the untouched sensor at full light. What
    passes in the room (`rig.passing`) moves with the stream's time, by the stream's seed.
    Where it is live (`rig.camera.live`), or where rows lie between frames, a frame depends on those grabbed before it,
    and each grabbed one is rendered whether it is developed or not.
    """

    def __init__(
        self, scene: SceneConfig, *, workspace: Workspace | None = None, quality: str | Quality = "full",
        companion: SurfaceMesh | None = None, opposite: Callable[[], Sensor | None] | None = None,
        told: Told = on_stderr,
    ) -> None:  # fmt: skip
        """Builds geometry and lattice; the renderer loads when the first frame is taken.

        Args:
            scene: Design, rig, object, contact and render settings; its keyframes do not matter.
            workspace: Where the object may go. The lattice is fine where it can touch, so a small one is faster.
            quality: `full`, or `control` for a coarser and faster sensor, see `magicsim.robot.quality`.
            companion: What is seen beside the object where `accompany` puts it, with colours, in its own frame.
            opposite: Gives the sensor that `face` puts before this one, once it is seen; by default one like this.
            told: Hears what takes longer than two seconds; it is written to stderr by default.

        Raises:
            ConfigError: The workspace goes too deep, the scene depends on time, or the camera codes a video.
            GeometryError: The design cannot be built.
            RenderError: The estimator cannot render these materials.
        """
        if (memory := scene.contact.memory) is not None:
            raise ConfigError(
                f"{memory} is not allowed here: the motions of a live sensor are quasi-static and elastic"
            )
        if isinstance(scene.rig.camera.compression, H264):
            raise ConfigError(
                "rig.camera.compression.kind = 'h264' is not allowed here: frames of a live sensor are developed in "
                "any order; must be 'mjpeg' or left out"
            )
        self.workspace = workspace or Workspace()
        self._told = told
        self._scene = placed = find_quality(quality).applied(scene)
        states = self.workspace.states(placed)
        with waiting("building block and lattice", told):
            sensor = Sensor.for_scene(placed, states=states, companion=companion, opposite=opposite)
            self._darkroom: Darkroom | None = Darkroom(sensor, placed.output)
        self._moment = Moment(
            seed=sensor.seed, index=0, time_s=0.0, frames_per_second=scene.frames_per_second, deformation=sensor.rest
        )
        target = sensor.object
        spacing = {"point_spacing_mm": point_spacing_mm(target.shape())} if target is not None else {}
        self.contact_area_mm2 = contact_face(sensor.lattice, **spacing).area_mm2
        """Rest area of each contact point, shape (points,) [mm2]."""

    def reset(self, *, seed: int | None = None) -> None:
        """Back to the untouched sensor at full light, the stream at its first frame.

        Args:
            seed: Of the frames' noise; the scene's by default. The rendering itself keeps the scene's seed.

        Raises:
            ConfigError: The seed is not allowed.
        """
        asked = self.sensor.seed if seed is None else seed
        check_number("seed", asked, 0, MAX_SEED - 1, whole=True)
        rate, rest = self.frames_per_second, self.sensor.rest
        self._moment = Moment(seed=int(asked), index=0, time_s=0.0, frames_per_second=rate, deformation=rest)

    @property
    def sensor(self) -> Sensor:
        """The solver and renderer behind; `ConfigError` once the sensor is closed."""
        return self._open.sensor

    @property
    def scene(self) -> SceneConfig:
        """What the sensor was made of, with its present rig; the keyframes do not matter."""
        return self._scene.model_copy(update={"rig": self.sensor.rig})

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        return self._darkroom is None

    @property
    def frames_per_second(self) -> float:
        """Frames in a second of simulated time [1/s]."""
        return self._moment.frames_per_second

    @property
    def frame_index(self) -> int:
        """Number of frames grabbed since the stream began."""
        return self._moment.index

    @property
    def time_s(self) -> float:
        """Simulated time of the next frame [s]."""
        return self._moment.time_s

    @property
    def state(self) -> FrameState:
        """Where object and outside light are, and what passes in the room at the time of the next frame."""
        return with_passing(self._moment.state, self.sensor.rig, time_s=self.time_s, seed=self._moment.seed)

    @property
    def deformation(self) -> Deformation:
        """The present equilibrium."""
        return self._moment.deformation

    @property
    def slip_share(self) -> float:
        """Share of the normal force that presses on sliding points, 0..1; see `magicsim.robot.workspace`."""
        return slip_share(self.deformation, self.contact_area_mm2)

    @property
    def slid_mm(self) -> float:
        """How far the skin has slid over the object since the stream began, see `magicsim.robot.workspace` [mm]."""
        return self._moment.slid_mm

    @property
    def truth(self) -> FrameTruth:
        """Ground truth of the present state, as the next frame would have it."""
        return self.now().truth(self.sensor.design.limits)

    def move_to(
        self, *, gap_mm: float | None = None, x_mm: float | None = None, y_mm: float | None = None,
        twist_deg: float | None = None, tilt_x_deg: float | None = None, tilt_y_deg: float | None = None,
    ) -> None:  # fmt: skip
        """Moves the object in a straight line and finds the equilibrium at its end; what is None stays.

        Args:
            gap_mm: Distance of its highest point from the undeformed contact face [mm], negative when pressed.
            x_mm: Its origin along x [mm].
            y_mm: Its origin along y [mm].
            twist_deg: Its rotation about z [degrees].
            tilt_x_deg: Its tilt after the twist, a rotation vector: along x [degrees].
            tilt_y_deg: Along y [degrees].

        Raises:
            ConfigError: There is no object, no gap yet, or the pose is outside of the workspace.
            ConvergenceError: No valid equilibrium was found; the sensor stays where it was.
        """
        asked = zip(RANGES, (x_mm, y_mm, twist_deg, tilt_x_deg, tilt_y_deg, gap_mm), strict=True)
        given = {name: float(value) for name, value in asked if value is not None}
        self._go(replace(self._moment.state, **given))  # type: ignore[arg-type]

    def go_back(self, moment: Moment) -> None:
        """Object, lights and the history of the contact as they were at a moment; the stream goes on.

        Args:
            moment: From `grab` or `now` of this sensor.
        """
        self._change(
            state=replace(moment.state, passing_mm=None), deformation=moment.deformation, slid_mm=moment.slid_mm,
            led_strength=moment.led_strength,
        )  # fmt: skip

    def remove_object(self) -> None:
        """Takes the object away; the skin forgets it."""
        self._go(_without_object(self._moment.state))

    def face(self, distance_mm: float | None) -> None:
        """Puts another finger of the same kind before this one, turned by half a turn about y, or takes it away.

        It is seen and shines (`magicsim.light.facing`), and touches nothing.

        Args:
            distance_mm: Between both contact faces [mm]; None takes it away.

        Raises:
            ConfigError: The fingers would pass through each other.
        """
        if distance_mm is not None:
            check_number("distance_mm", distance_mm, LEAST_WIDTH_MM, FARTHEST_MM)
        self._set(facing_mm=None if distance_mm is None else float(distance_mm))

    def accompany(self, pose: Pose | None) -> None:
        """Puts what is seen beside the object somewhere, or takes it away; it touches nothing.

        It is in the picture only while another finger is (`face`), and goes with the object when that is removed.

        Args:
            pose: From its own frame to the sensor's; None takes it away.

        Raises:
            ConfigError: The sensor was built without a companion.
        """
        if self.sensor.companion is None and pose is not None:
            raise ConfigError("companion is missing: build the sensor with what is to be seen beside its object")
        self._set(companion=None if pose is None else pose.key())

    def shine(self, *, on: bool = True, x_mm: float = 0.0) -> None:
        """Turns the flashlight on, shifted along x [mm] as far as is allowed (`ConfigError`), or off."""
        check_number("x_mm", x_mm, -FARTHEST_MM, FARTHEST_MM)
        self._set(flashlight=on, light_x_mm=float(x_mm) if on else 0.0)

    def set_led_strength(self, red: float, green: float, blue: float) -> None:
        """LED strips' red, green and blue, each 0 to 1000 (`ConfigError`) times the rig's; exposure stays locked."""
        strength = (float(red), float(green), float(blue))
        for each in strength:
            check_number("LED strength", each, 0, STRONGEST)
        self._change(led_strength=strength)

    def set_exposure_grey(self, exposure_grey: float) -> None:
        """Meters again, aiming at a mean grey level of the untouched sensor of 1 to 254 (`ConfigError` for others)."""
        self._darkroom, self._moment = self._open.exposed(exposure_grey), replace(self._moment, memory=None)

    def set_frame_rate(self, frames_per_second: float) -> None:
        """Sets the time from frame to frame, by 0.001 to 1000 frames a second (`ConfigError` for others)."""
        check_number("frames_per_second", frames_per_second, MIN_FRAME_RATE, MAX_FRAME_RATE)
        self._change(frames_per_second=float(frames_per_second))

    def set_image_size(self, *, columns: int, rows: int) -> None:
        """Renders with so many pixels (`ConfigError` for too many) from now on, which see `camera.field_mm` along x."""
        darkroom = self._open.resized(columns=columns, rows=rows)
        self._darkroom, self._moment = darkroom, replace(self._moment, memory=None)

    def now(self) -> Moment:
        """The present moment, without taking it from the stream."""
        return replace(self._moment, state=self.state)

    def grab(self) -> Moment:
        """Takes the next moment of the stream without developing it, and lets one frame's time pass.

        Raises:
            RenderError: The camera's next frame depends on this one, whose image is not valid.
        """
        moment, memory = self.now(), self._moment.memory
        if self.sensor.rig.camera.history:
            with waiting(self._rendering, self._told):
                memory = self._open.passed(moment)
        later_s = moment.time_s + 1 / moment.frames_per_second
        self._change(index=moment.index + 1, time_s=later_s, memory=memory)
        return moment

    def develop(self, moment: Moment) -> SimulatedFrame:
        """Renders a moment, `RenderError` where the image is not valid; equal states are rendered once."""
        with waiting(self._rendering, self._told):
            return self._open.develop(moment)

    def frame(self) -> SimulatedFrame:
        """The next frame: RGB image, shape (rows, columns, 3), and ground truth; one that fails is still to come."""
        with still_to_come(self):
            return self.develop(self.grab())

    def close(self) -> None:
        """Lets go of solver, scenes and images; may be called again."""
        self._darkroom = None

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def _rendering(self) -> str:
        return PICTURE if self._open.is_metered else FIRST_PICTURE

    @property
    def _open(self) -> Darkroom:
        if self._darkroom is None:
            raise ConfigError("the sensor is closed: build another one")
        return self._darkroom

    def _change(self, **values: Any) -> None:  # noqa: ANN401 - fields of `Moment`
        """Replaces what belongs together at once, so that an interrupt finds all of it or nothing."""
        self._moment = replace(self._moment, **values)

    def _set(self, **values: Any) -> None:  # noqa: ANN401 - fields of `FrameState`
        self._change(state=replace(self._moment.state, **values))

    def _go(self, state: FrameState) -> None:
        sensor, now = self.sensor, self._moment
        if state.gap_mm is None and state != _without_object(state):
            msg = "gap_mm is missing: there is no object yet, so the first motion must say how far away it is"
            raise ConfigError(msg)
        if state.has_object and sensor.object is None:
            raise ConfigError("object is missing: the scene of this sensor has none to move")
        self.workspace.check(state)
        if state == now.state:
            return
        with waiting("solving the contact", self._told):
            deformation, slid_mm = travel(sensor, now.state, state, now.deformation, self.contact_area_mm2)
        self._change(state=state, deformation=deformation, slid_mm=now.slid_mm + slid_mm)


def _without_object(state: FrameState) -> FrameState:
    return replace(UNTOUCHED, flashlight=state.flashlight, light_x_mm=state.light_x_mm, facing_mm=state.facing_mm)


@contextmanager
def still_to_come(*sensors: LiveSensor) -> Iterator[None]:
    """Frames of these sensors, of which none is taken from its stream where one fails or is interrupted."""
    before = [each._moment for each in sensors]
    try:
        yield
    except BaseException:
        for each, then in zip(sensors, before, strict=True):
            each._change(index=then.index, time_s=then.time_s, memory=then.memory)
        raise


def live_sensor(
    scene: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None, workspace: Workspace | None = None,
    quality: str | Quality = "full", told: Told = on_stderr,
) -> LiveSensor:  # fmt: skip
    """A live sensor from a scene preset or file.

    Args:
        scene: Scene preset or TOML file: design, rig and object.
        overrides: `dotted.key=value` settings.
        seed: Seed instead of the file's.
        workspace: Where the object may go.
        quality: `full` or `control`, see `magicsim.robot.quality`.
        told: Hears what takes longer than two seconds.

    Raises:
        MagicsimError: As `load_scene` and `LiveSensor`.
    """
    loaded = load_scene(scene, overrides, seed=seed)
    return LiveSensor(loaded, workspace=workspace, quality=quality, told=told)
