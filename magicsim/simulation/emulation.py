"""Which pictures of a sensor are emulated, and by what (`render.tier = "fast"`)."""

import hashlib
import logging
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.exposure import meter
from magicsim.camera.projection import pixel_landing_mm
from magicsim.deform.deformation import Deformation, Displacement
from magicsim.emulator.emulator import EMULATED, OFF, Emulator, compared, known_model
from magicsim.emulator.fields import FieldMaker
from magicsim.errors import ConfigError, RenderError
from magicsim.light.frame.frame_light import LIFTED_MM
from magicsim.light.near.near_views import NearViews
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin, TierError
from magicsim.simulation.truth import contact_mask

if TYPE_CHECKING:
    from magicsim.simulation.sensor import Sensor

COMPRESSED = Origin(light="outside", image="compressed")
LOGGER = logging.getLogger(__name__)
CHECKED_SHARE = 0.01
"""Share of a dataset's emulated frames that are rendered truly as well."""
CHECK_SEED = 0
"""Random numbers of all of these, so that what they take of the untouched sensor is recorded once for all episodes."""


def before_contact(state: FrameState) -> FrameState:
    """The state with its object moved back until it only just does not touch."""
    return replace(state, gap_mm=LIFTED_MM)


@dataclass(slots=True, kw_only=True)
class Emulation:
    """The emulator of one sensor, once a touch asks for it, and what was said of touches that it does not know."""

    checked_share: float = 0.0
    """Share of the emulated frames that are rendered truly as well, to tell how far off they are."""
    emulator: Emulator | str | None = None
    """A text says why there is none."""
    landing_mm: Array = field(default_factory=lambda: np.zeros(0))
    """Where pixels look on the contact face, shape (rows, columns, 2) [mm]."""
    near: NearViews | None = None
    """Shows what does not touch, once a state asks for it."""
    said: set[str] = field(default_factory=set)

    def frame(
        self, sensor: "Sensor", state: FrameState, deformation: Deformation | Displacement
    ) -> tuple[FloatImage, Origin] | None:
        """Radiance of what is near or touches, and its origin; None for states that are rendered.

        Raises:
            ConfigError: The model does not know the touch, and the scene wants no true frame then.
            RenderError: A frame that was checked is farther off than the model says that its frames are.
        """
        shows = state.gap_mm is not None or state.flashlight or state.passing_mm is not None
        if not shows or not isinstance(deformation, Deformation):
            return None
        if self.emulator is None:
            self.emulator = self._emulator(sensor)
            self.landing_mm = pixel_landing_mm(sensor.design, sensor.rig.lens, sensor.rig.camera)
        emulator = self.emulator
        if isinstance(emulator, str):
            self._refuse(sensor, emulator)
            return None
        if not state.can_touch or deformation.is_rest:
            if state.gap_mm is not None and 0 <= state.gap_mm < LIFTED_MM:  # where true frames count it as touching
                state = before_contact(state)
            if self.near is None:
                self.near = NearViews(sensor.renderer)
            near = self.near.radiance(sensor.view(state, deformation))
            return (near, COMPRESSED) if near is not None else None
        if (problem := emulator.refusal(state)) is not None:
            self._refuse(sensor, problem)
            return None
        image = emulator.radiance(
            before_contact(state), sensor.printed_displacements_mm(deformation),
            contact_mask(deformation, self.landing_mm), lambda free: sensor.radiance(free, sensor.rest),
        )  # fmt: skip
        if not self._is_checked(sensor.seed, state):
            return image, EMULATED
        return image, replace(EMULATED, error=self._error(sensor, state, deformation, image))

    def _emulator(self, sensor: "Sensor") -> Emulator | str:
        model = known_model(sensor.design, sensor.rig, sensor.object, sensor.contact, sensor.settings)
        if isinstance(model, str):
            return model
        image = sensor.radiance(UNTOUCHED, sensor.rest)

        def made() -> FieldMaker:
            return FieldMaker.of(sensor.design, sensor.rig, sensor.printed.nodes_mm, image)

        def fields() -> FieldMaker:
            # A unit is known by its light: another lens may blur it otherwise.
            kept = sensor.renderer.of_sensor("fields", made)
            return kept if np.array_equal(kept.rest, image) else made()

        return Emulator.of(model, sensor.design, sensor.rig, image, fields)

    def _is_checked(self, seed: int, state: FrameState) -> bool:
        """Drawn by the frame itself, so that it does not depend on who renders it when."""
        digest = hashlib.sha256(f"{seed} {state}".encode()).digest()
        return int.from_bytes(digest[:4]) < self.checked_share * 2**32

    def _error(self, sensor: "Sensor", state: FrameState, deformation: Deformation, image: FloatImage) -> TierError:
        true = sensor.renderer.reseeded(seed=CHECK_SEED).radiance(sensor.view(state, deformation))
        gain = 255 * meter(sensor.radiance(UNTOUCHED, sensor.rest), sensor.rig.camera, sensor.lit)
        error = compared(image, true, gain)
        assert isinstance(self.emulator, Emulator)
        if error.mean > (bound := self.emulator.bound):
            raise RenderError(f"{OFF} {error.mean:.2g} grey levels in a touch, at most {bound:.2g} is allowed: {state}")
        return error

    def _refuse(self, sensor: "Sensor", problem: str) -> None:
        if sensor.settings.outside_domain == "refuse":
            way = "render.outside_domain = 'true' renders truly"
            raise ConfigError(f"render.tier = 'fast' is not allowed here: {problem}; {way}")
        if problem not in self.said:
            self.said.add(problem)
            LOGGER.warning("true frames in place of fast ones: %s", problem)
