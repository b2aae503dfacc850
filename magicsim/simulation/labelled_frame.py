"""From a rendered state to a labelled frame: the camera's 8-bit image and all that is known about it."""

import logging
from dataclasses import dataclass, field
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import FloatImage, Frame
from magicsim.camera.exposure import Exposure
from magicsim.camera.projection import pixel_landing_mm, project_px
from magicsim.camera.stream import CameraMemory, CameraStream, Instant
from magicsim.deform.deformation import Deformation
from magicsim.deform.solve.factorise import on_one_blas_thread
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import OutputSettings
from magicsim.scenes.timeline import UNKNOWN_ORIGIN, FrameState, Origin
from magicsim.simulation.episode import FrameLabels, SimulatedFrame
from magicsim.simulation.touch_truth import TouchFields
from magicsim.simulation.truth import contact_mask, depth_map_mm, frame_truth

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
    warned: set[str] = field(default_factory=set)
    """Warnings that were given; each is given once."""

    def see_exposure(self, exposure: Exposure) -> None:
        """Warns where exposure had to make up for nearly all of the light being lost."""
        brightest = max((max(radiance) for radiance in self.rig.lamps), default=0.0)
        if brightest * float(np.max(exposure.gain)) > FAINT_SIGNAL:
            self._warn("next to no light reaches the camera, and frames show the noise of the rendering: " + GEL)

    def see(self, image: Frame, *, index: int, flashlight: bool) -> None:
        """Warns of the first black and of the first saturated frame.

        Args:
            image: RGB, shape (rows, columns, 3).
            index: Number of the frame in its stream.
            flashlight: Whether the flashlight is on.
        """
        mean = float(image.mean())
        if mean < BLACK_GREY:
            self._warn(f"frame {index} is black (mean grey level {mean:.2g}): {self._why_black()}", key="black")
        white = float((image.min(2) == np.iinfo(np.uint8).max).mean())
        if white > WHITE_SHARE:
            lamp = f" with rig.flashlight.radiance = {list(self.rig.flashlight.radiance)}" if flashlight else ""
            why = f"rig.camera.exposure_grey = {self.rig.camera.exposure_grey:g}{lamp} is too bright"
            self._warn(f"frame {index} is saturated ({white:.0%} of its pixels are white): {why}", key="white")

    def _why_black(self) -> str:
        if not any(self.rig.lit):
            return "no light of rig.strips, rig.leds and rig.ring shines, and the room is dark (rig.ambient, rig.room)"
        return f"no light reaches the camera: {GEL}"

    def _warn(self, message: str, *, key: str = "") -> None:
        if key not in self.warned:
            self.warned.add(key)
            LOGGER.warning("%s", message)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """Everything that turns a radiance into a labelled frame of one sensor."""

    design: ElastomerDesign
    """The block."""
    rig: Rig
    """What surrounds it."""
    output: OutputSettings
    """What a frame holds beside its image."""
    camera: CameraStream
    """Exposed on the untouched sensor."""
    landing_mm: npt.NDArray[np.float64] | None
    """Where pixels look, see `pixel_landing_mm`; None where no output needs it."""
    watch: BrightnessWatch
    """Tells frames that are black or saturated."""

    @classmethod
    def of(cls, design: ElastomerDesign, rig: Rig, output: OutputSettings, camera: CameraStream) -> Self:
        """For a sensor whose camera is exposed on its untouched state."""
        needed = output.contact_mask or output.depth_map
        watch = BrightnessWatch(rig=rig)
        watch.see_exposure(camera.exposure)
        landing = pixel_landing_mm(design, rig.lens, rig.camera) if needed else None
        return cls(design=design, rig=rig, output=output, camera=camera, landing_mm=landing, watch=watch)

    @on_one_blas_thread
    def take(
        self,
        state: FrameState,
        deformation: Deformation,
        radiance: FloatImage,
        memory: CameraMemory,
        at: Instant,
        *,
        displacements_mm: npt.NDArray[np.float32] | None,
        is_reference: bool,
        origin: Origin = UNKNOWN_ORIGIN,
        markers_mm: npt.NDArray[np.float64] | None = None,
        touch: TouchFields | None = None,
    ) -> tuple[SimulatedFrame, CameraMemory]:
        """One frame, and what the camera's next one inherits.

        Args:
            state: What is in front of the sensor.
            deformation: Its equilibrium.
            radiance: What the camera reads out, linear, shape (rows, columns, 3).
            memory: What the camera inherits from the frames before.
            at: Which frame of which stream; each has noise of its own.
            displacements_mm: Of the design's lattice, shape (nodes, 3) [mm], where they are asked for.
            is_reference: Whether the frame makes the references.
            origin: How the radiance was made.
            markers_mm: Centres of the markers, shape (markers, 3) [mm], where there are any.
            touch: Fields of touch, where they are asked for.
        """
        output, landing = self.output, self.landing_mm
        image, later = self.camera.take(radiance, memory, at)
        self.watch.see(image, index=at.index, flashlight=state.flashlight)
        frame = SimulatedFrame(
            image=image,
            truth=frame_truth(state, deformation, index=at.index, time_s=at.time_s, is_reference=is_reference),
            labels=FrameLabels(
                contact_mask=contact_mask(deformation, landing)
                if landing is not None and output.contact_mask
                else None,
                displacements_mm=displacements_mm,
                depth_map_mm=depth_map_mm(deformation, landing, self.design)
                if landing is not None and output.depth_map
                else None,
                markers_mm=markers_mm,
                markers_px=project_px(markers_mm, self.design, self.rig.lens, self.rig.camera)
                if markers_mm is not None
                else None,
                touch=touch,
            ),
            origin=origin,
        )
        return frame, later
