"""Frames of one renderer in which nothing touches, and the anchor that frames with a touch have of the last such one.

What comes into contact was just before it: light and image of that state are known well, from recorded paths, and
cheaply, from paths with the random numbers of the frame. A touched frame differs from the cheap one by what the touch
changes, so that its noise and its mean begin where those of the untouched frames end.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.anchor import Anchor
from magicsim.scenes.approach import flashlight_outside, recorded, seen_outside, strips_outside, try_out
from magicsim.scenes.film import Film
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.outside import Outside, Outsides
from magicsim.scenes.plain_renderer import FloatImage, checked
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.untouched import RECORDED_PER_PARTICLE, Recorded, UntouchedStates
from magicsim.scenes.untouched_passes import follow_light

Array = npt.NDArray[np.float64]
LIFTED_MM = 2e-3
"""Gap of the last state before contact [mm]."""
CHANNELS = 3


def lifted(vertices: Array) -> Array:
    """The object moved back along z until it only just does not touch, shape (vertices, 3) [mm].

    Args:
        vertices: The object where it is, of the same shape [mm].
    """
    return np.asarray(vertices - np.array([0.0, 0.0, vertices[:, 2].max() + LIFTED_MM]))


def by_channel(field: LightField) -> dict[str, LightField]:
    """One field for each channel, dark in the others: what changes one colour of light need not change another."""
    return {
        f"channel {number}": LightField(
            fluence=field.fluence * only, body=field.body * only, irradiance=field.irradiance * only
        )
        for number, only in enumerate(np.eye(CHANNELS))
    }


class FreeStates:
    """What was recorded of one untouched sensor, carefully and as a frame would trace it, and what stands before it."""

    def __init__(
        self,
        scene: Any,
        rig: Rig,
        settings: RenderSettings,
        *,
        seed: int,
        object_mesh: SurfaceMesh | None,
        object_finish: Finish,
        film: Film,
        untouched: UntouchedStates,
        key: str,
    ) -> None:
        """Records nothing yet.

        Args:
            scene: The loaded scene, with nothing before the block.
            rig: What surrounds the block.
            settings: Samples and particles.
            seed: Monte Carlo seed of the frames.
            object_mesh: The object in its own frame, or None.
            object_finish: Its surface.
            film: What is read out of the image.
            untouched: Where careful records are looked up and kept.
            key: Of the untouched state.
        """
        self._scene, self._settings, self._seed, self._finish, self._film = scene, settings, seed, object_finish, film
        self._untouched, self._key = untouched, f"{key} {settings.particles}"
        self._outsides = Outsides(rig, object_mesh, object_finish)
        self._cheap: Recorded | None = None

    def careful(self) -> Recorded:
        """Camera paths and light of the untouched sensor, as many as its anchor has."""
        known = self._untouched.recorded(self._key)
        if known is None:
            settings = self._settings
            known = recorded(
                self._scene, seed=settings.anchor_seed, samples=settings.anchor_samples,
                particles=RECORDED_PER_PARTICLE * settings.particles,
            )  # fmt: skip
            self._untouched.keep_recorded(self._key, known)
        return known

    def cheap(self) -> Recorded:
        """Camera paths and light of the untouched sensor, with the samples and random numbers of a frame."""
        if self._cheap is None:
            settings = self._settings
            self._cheap = recorded(self._scene, seed=self._seed, samples=settings.samples, particles=settings.particles)
        return self._cheap

    def try_out(self, vertices: Array | None, light_x_mm: float | None) -> None:
        """Compiles what a frame with such things needs; arguments as of `image`."""
        try_out(self._scene, self._outsides.of(vertices, light_x_mm), self._finish, seed=self._seed)

    def image(self, vertices: Array | None, light_x_mm: float | None, anchor: Anchor) -> FloatImage:
        """Radiance of a frame in which nothing touches, shape (rows, columns, 3).

        Args:
            vertices: Of the object where it is, shape (vertices, 3) [mm]; None where there is none.
            light_x_mm: Shift of the flashlight [mm]; None while it is off.
            anchor: The untouched sensor; its images are those of the film.
        """
        outside = self._outsides.of(vertices, light_x_mm)
        strips = strips_outside(self._scene, outside, self.careful().light, anchor, seed=self._seed)
        field = total([strips, flashlight_outside(self._scene, outside, seed=self._seed)])
        return self._seen(outside, self.careful(), field, anchor, anchor.image)

    def anchor(self, vertices: Array, light_x_mm: float | None, anchor: Anchor) -> Anchor:
        """The last state before contact, to anchor a touched frame to; its light is told apart by channel.

        Args:
            vertices: Of the object where it touches, shape (vertices, 3) [mm].
            light_x_mm: Shift of the flashlight [mm]; None while it is off.
            anchor: The untouched sensor; its images are those of the film.
        """
        outside = self._outsides.of(lifted(vertices), light_x_mm)
        strips = strips_outside(self._scene, outside, self.careful().light, anchor, seed=self._seed)
        lamp = flashlight_outside(self._scene, outside, seed=self._seed)
        back = follow_light(self._scene, outside, self.cheap().light, seed=self._seed)
        rest = total([self._scene.integrator().darkness(self._scene), *anchor.cheap.values()])
        cheap = replace(rest, fluence=rest.fluence + back.fluence, irradiance=back.irradiance)
        # The cheap image has the careful light in the block, as the frame will, and its own on the object.
        shown = total([replace(strips, irradiance=back.irradiance), lamp])
        return replace(
            anchor,
            cheap=by_channel(cheap),
            careful=by_channel(strips),
            cheap_image=self._seen(outside, self.cheap(), shown, anchor, anchor.cheap_image),
            image=self._seen(outside, self.careful(), total([strips, lamp]), anchor, anchor.image),
        )

    def _seen(
        self, outside: Outside, known: Recorded, field: LightField, anchor: Anchor, rest: FloatImage
    ) -> FloatImage:
        change = seen_outside(
            self._scene, outside, known.paths, field, anchor, self._finish, self._film.window,
            samples=self._settings.samples, seed=self._seed,
        )  # fmt: skip
        return np.asarray(np.maximum(self._film.seen(checked(change.astype(np.float32))) + rest, 0))
