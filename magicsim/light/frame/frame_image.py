"""Image of one frame from recorded camera paths: what light and things outside change of the untouched sensor's image.

A path serves as long as no surface that it meets inside the block has moved. What it then meets outside, and the light
that it gathers on its way, are those of the frame. Where a press has moved something on a pixel's way, its paths are
traced anew, with the random numbers of recorded ones: what both differ by is the change (`anchored_image`).
"""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Numbers
from magicsim.light.records.untouched import Untouched
from magicsim.light.records.untouched_passes import follow_camera
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.outside import Outside

MIRRORED_PER_SAMPLE = 3
"""Paths that a glossy object sends on, for each camera sample: its highlights are small and bright."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """What a frame shows to paths through the untouched block."""

    world: LitWorld
    """The scene with nothing before the block."""
    outside: Outside
    """What stands there."""
    field: LightField
    """Light in the block and on the object."""
    samples: int
    """Camera samples of each pixel that are traced on where the object mirrors."""
    seed: int
    """Seed of the frame."""

    def through(self, rest: Untouched, light: LightField, pixels: Numbers) -> Array:
        """Radiance of some pixels by the paths of one record, shape (pixels, 3).

        Args:
            rest: The untouched sensor, with its paths.
            light: Of the untouched sensor, that its image was gathered from.
            pixels: Numbers of the pixels, row by row of the film.
        """
        change = LightField(
            fluence=self.field.fluence - light.fluence, body=self.field.body - light.body, irradiance=light.irradiance
        )
        paths, world, finish = rest.paths, self.world, self.world.content.object_finish
        seen = paths.glow(world.elements(change), pixels)
        seen += paths.seen_outside(world.inventory.environment, self.outside, self.field.irradiance, finish, pixels)
        seen += paths.mirrored(
            self.outside, finish, pixels, lambda starts: follow_camera(
                world, self.outside, starts, self.field, seed=self.seed
            ), samples=MIRRORED_PER_SAMPLE * self.samples, seed=self.seed,
        )  # fmt: skip
        return np.asarray(np.maximum(rest.image.reshape(-1, 3)[pixels] + seen, 0))


def own_field(world: LitWorld, rest: Untouched) -> LightField:
    """Light of all lights of the untouched sensor."""
    return total([world.darkness(), *rest.fields.values()])
