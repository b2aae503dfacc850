"""From a scene to its labelled frames and ground truth: the chain that everything else builds on."""

import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage, Frame
from magicsim.camera.projection import picture_mm, pixel_landing_mm, project_px
from magicsim.camera.stream import CameraMemory, CameraStream, Instant
from magicsim.deform.deformation import Deformation
from magicsim.deform.solve.factorise import on_one_blas_thread
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import OutputSettings, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin
from magicsim.simulation.episode import Episode, FrameLabels, SimulatedFrame
from magicsim.simulation.plan import UNTOUCHED_FRAME, FramePlan, ScenePlan, plan_scene
from magicsim.simulation.sensor import Sensor, sensor_camera
from magicsim.simulation.touch_truth import TouchFields
from magicsim.simulation.truth import contact_mask, depth_map_mm, frame_truth, is_in_view
from magicsim.waiting import Told, on_stderr, unheard, waiting

LOGGER = logging.getLogger(__name__)
BLACK_GREY = 1.0
"""Mean grey level below which a frame counts as black."""
WHITE_SHARE = 0.5
"""Share of pixels at 255 in all channels above which a frame counts as saturated."""
FAINT_SIGNAL = 1e6
"""A light seen directly would be so many times brighter than white where next to nothing of it reaches the camera."""
GEL = "it does through scattering (design.materials.infill.sigma_s_per_mm) and less absorption (absorption_per_mm)"


@dataclass(slots=True, kw_only=True)
class BrightnessWatch:
    """Warns, once each, of frames of one sensor that show nothing, with the field that makes them so."""

    rig: Rig
    lit: tuple[bool, bool, bool]
    """Whether any light of the untouched sensor shines in red, green and blue."""
    warned: set[str] = field(default_factory=set)
    """Warnings that were given; each is given once."""

    def see_exposure(self, gain: Array) -> None:
        """Warns where exposure had to make up for nearly all of the light being lost."""
        brightest = max((max(radiance) for radiance in self.rig.lamps), default=0.0)
        if brightest * float(np.max(gain)) > FAINT_SIGNAL:
            self._warn("next to no light reaches the camera, and frames show the noise of the rendering: " + GEL)

    def see(self, image: Frame, *, index: int, flashlight: bool) -> None:
        """Warns of the first black and of the first saturated frame."""
        mean = float(image.mean())
        if mean < BLACK_GREY:
            why = f"no light reaches the camera: {GEL}"
            if not any(self.lit):
                coat, dark = "behind an opaque coat (design.coat)", "dark (rig.ambient, rig.room)"
                room = coat if any(self.rig.room_light) else dark
                why = f"no light of rig.strips, rig.leds and rig.ring shines, and the room is {room}"
            self._warn(f"frame {index} is black (mean grey level {mean:.2g}): {why}", key="black")
        white = float((image.min(2) == np.iinfo(np.uint8).max).mean())
        if white > WHITE_SHARE:
            lamp = f" with rig.flashlight.radiance = {list(self.rig.flashlight.radiance)}" if flashlight else ""
            why = f"rig.camera.exposure_grey = {self.rig.camera.exposure_grey:g}{lamp} is too bright"
            self._warn(f"frame {index} is saturated ({white:.0%} of its pixels are white): {why}", key="white")

    def _warn(self, message: str, *, key: str = "") -> None:
        if key not in self.warned:
            self.warned.add(key)
            LOGGER.warning("%s", message)


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderedState:
    """One frame of the stream before the camera: everything that noise and exposure do not change."""

    state: FrameState
    deformation: Deformation
    radiance: FloatImage
    """Linear radiance, shape (rows, columns, 3); the same array for all frames that look the same."""
    origin: Origin
    is_reference: bool
    """Whether the frame makes the references."""
    index: int = 0
    """Place in an episode, reference frames included."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """Everything that turns a radiance into a labelled frame of one sensor."""

    sensor: Sensor
    output: OutputSettings
    """What a frame holds beside its image."""
    camera: CameraStream
    """Exposed on the untouched sensor."""
    landing_mm: npt.NDArray[np.float64] | None
    """Where pixels look, see `pixel_landing_mm`; None where no output needs it."""
    view_mm: npt.NDArray[np.float64]
    """What of the contact face the picture covers, see `picture_mm`."""
    watch: BrightnessWatch
    """Tells frames that are black or saturated."""

    @classmethod
    def of(cls, sensor: Sensor, output: OutputSettings, camera: CameraStream) -> Self:
        """For a sensor whose camera is exposed on its untouched state."""
        needed, rig = output.contact_mask or output.depth_map, sensor.rig
        watch = BrightnessWatch(rig=rig, lit=sensor.lit)
        watch.see_exposure(camera.gain)
        landing = pixel_landing_mm(sensor.design, rig.lens, rig.camera) if needed else None
        view = picture_mm(sensor.design, rig.lens, rig.camera)
        return cls(sensor=sensor, output=output, camera=camera, landing_mm=landing, view_mm=view, watch=watch)

    @on_one_blas_thread
    def take(
        self, rendered: RenderedState, memory: CameraMemory, at: Instant, *, touch: TouchFields | None = None
    ) -> tuple[SimulatedFrame, CameraMemory]:
        """One frame, and what the camera's next one inherits."""
        state, deformation = rendered.state, rendered.deformation
        sensor, output, landing = self.sensor, self.output, self.landing_mm
        design, rig, markers_mm = sensor.design, sensor.rig, sensor.markers_mm(deformation)
        image, later = self.camera.take(rendered.radiance, memory, at)
        self.watch.see(image, index=at.index, flashlight=state.flashlight)
        mask = contact_mask(deformation, landing) if landing is not None and output.contact_mask else None
        depth = depth_map_mm(deformation, landing, design) if landing is not None and output.depth_map else None
        frame = SimulatedFrame(
            image=image,
            truth=frame_truth(
                state, deformation, design.limits, index=at.index, time_s=at.time_s, is_reference=rendered.is_reference
            ),
            labels=FrameLabels(
                contact_mask=mask,
                displacements_mm=sensor.printed_displacements_mm(deformation) if output.displacements else None,
                depth_map_mm=depth,
                markers_mm=markers_mm,
                markers_px=project_px(markers_mm, design, rig.lens, rig.camera) if markers_mm is not None else None,
                touch=touch,
                in_view=is_in_view(state, deformation, self.view_mm),
            ),
            origin=rendered.origin,
        )
        return frame, later


Progress = Callable[[int, int], None]
"""Called after every frame with the work done and all work, in the same arbitrary unit."""


def simulate(
    scene: SceneConfig, *, plan: ScenePlan | None = None, progress: Progress | None = None, told: Told = on_stderr
) -> Episode:
    """Simulates a whole scene.

    Args:
        scene: What happens, on which sensor.
        plan: Which work to do; by default only what the scene needs.
        progress: Told after every frame.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    with waiting("simulating", told if progress is None else unheard) as share:
        plan = plan or plan_scene(scene)
        return simulate_with(Sensor.for_scene(scene), plan, progress=progress or share)


def simulate_with(sensor: Sensor, plan: ScenePlan, *, progress: Progress | None = None) -> Episode:
    """Simulates a planned scene with its sensor, already built; see `simulate`."""
    scene = plan.scene
    sensor.warm_up([frame.state for frame in plan.frames if frame.same_as is None])
    start = time.perf_counter()
    work = list(accumulate(plan.efforts))
    frames = []
    for frame, done in zip(stream_frames(sensor, plan), work, strict=True):
        frames.append(frame)
        sensor.limits.see(frame.truth.beyond_limits)
        if progress is not None:
            progress(done, work[-1])
    return Episode(scene=scene, frames=tuple(frames), seconds=time.perf_counter() - start)


def deformed(sensor: Sensor, frame: FramePlan, before: Deformation) -> Deformation:
    """The deformation in a frame of an episode, from that in the frame before."""
    if frame.solve:
        return sensor.deform(frame.state, before)
    is_held = frame.same_as not in {None, UNTOUCHED_FRAME}
    keeps = frame.state.can_touch or (is_held and sensor.contact.keeps_dent)
    return replace(before, iterations=0) if keeps else sensor.rest


def stream_states(sensor: Sensor, plan: ScenePlan, untouched: tuple[FloatImage, Origin]) -> Iterator[RenderedState]:
    """Rendered states of an episode in order: the references, of an untouched sensor, then what the plan lists."""
    first, deformation = len(plan.references), sensor.rest
    reused, rendered = {frame.same_as for frame in plan.frames}, {UNTOUCHED_FRAME: untouched}
    for number, frame in enumerate((*plan.references, *plan.frames), -first):
        deformation = deformed(sensor, frame, deformation)
        known = rendered[frame.same_as] if frame.same_as is not None else None
        radiance, origin = known or sensor.render(frame.state, deformation)
        if number >= 0 and number in reused:
            rendered[number] = radiance, origin
        yield RenderedState(
            state=frame.state, deformation=deformation, radiance=radiance, origin=origin, index=first + number,
            is_reference=number < 0,
        )  # fmt: skip


def stream_frames(sensor: Sensor, plan: ScenePlan) -> Iterator[SimulatedFrame]:
    """The frames of an episode in order: the references, then what the plan lists.

    A camera with a history (`Camera.history`) makes another frame of a state that returns, so all are exposed in order.
    """
    scene = plan.scene
    untouched = sensor.render(UNTOUCHED, sensor.rest)
    touch = sensor.touch_truth(scene.output.taxels) if scene.output.taxels is not None else None
    shot = Shot.of(sensor, scene.output, sensor_camera(sensor, untouched[0]))
    rate = scene.frames_per_second
    memory = shot.camera.begin(rate)
    for each in stream_states(sensor, plan, untouched):
        at = Instant(seed=scene.seed, index=each.index, time_s=each.index / rate, frames_per_second=rate)
        frame, memory = shot.take(each, memory, at, touch=touch.fields(each.deformation) if touch is not None else None)
        yield frame
