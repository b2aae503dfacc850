"""Frames that show nothing: black or saturated ones are told, once each, with the field that makes them so."""

import logging
from dataclasses import dataclass, field

import numpy as np

from magicsim.arrays import Frame
from magicsim.camera.exposure import Exposure
from magicsim.scenes.rig import Rig

LOGGER = logging.getLogger(__name__)
BLACK_GREY = 1.0
"""Mean grey level below which a frame counts as black."""
WHITE_SHARE = 0.5
"""Share of pixels at 255 in all channels above which a frame counts as saturated."""
FAINT_SIGNAL = 1e6
"""A light seen directly would be so many times brighter than white where next to nothing of it reaches the camera."""


@dataclass(slots=True, kw_only=True)
class BrightnessWatch:
    """Looks at the frames of one sensor as they are taken."""

    rig: Rig
    told: set[str] = field(default_factory=set)
    """What was said already."""

    def see_exposure(self, exposure: Exposure) -> None:
        """Warns where exposure had to make up for nearly all of the light being lost."""
        brightest = max((max(radiance) for radiance in self.rig.lamps), default=0.0)
        if brightest * float(np.max(exposure.gain)) > FAINT_SIGNAL:
            self._tell("next to no light reaches the camera, and frames show the noise of the rendering: " + _GEL)

    def see(self, image: Frame, *, index: int, flashlight: bool) -> None:
        """Warns of the first black and of the first saturated frame.

        Args:
            image: RGB, shape (rows, columns, 3).
            index: Number of the frame in its stream.
            flashlight: Whether the flashlight is on.
        """
        mean = float(image.mean())
        if mean < BLACK_GREY:
            self._tell(f"frame {index} is black (mean grey level {mean:.2g}): {self._why_black()}", key="black")
        white = float((image.min(2) == np.iinfo(np.uint8).max).mean())
        if white > WHITE_SHARE:
            lamp = f" with rig.flashlight.radiance = {list(self.rig.flashlight.radiance)}" if flashlight else ""
            why = f"rig.camera.exposure_grey = {self.rig.camera.exposure_grey:g}{lamp} is too bright"
            self._tell(f"frame {index} is saturated ({white:.0%} of its pixels are white): {why}", key="white")

    def _why_black(self) -> str:
        if not any(self.rig.lit):
            return "no light of rig.strips, rig.leds and rig.ring shines, and the room is dark (rig.ambient, rig.room)"
        return f"no light reaches the camera: {_GEL}"

    def _tell(self, message: str, *, key: str = "") -> None:
        if key not in self.told:
            self.told.add(key)
            LOGGER.warning("%s", message)


_GEL = "it does through scattering (design.materials.infill.sigma_s_per_mm) and less absorption (absorption_per_mm)"
