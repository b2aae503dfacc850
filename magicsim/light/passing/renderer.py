"""Radiance of a sensor before which something passes: that of the still room, and what the passing thing changes.

Rendering is linear in light, so records, light and frames of the still room serve as they are. The change is computed
by itself, with the sensor's own lights off: particles from where the thing is, what they leave in the block and on the
object, and what recorded camera paths meet of it. All its places share their random numbers, so the change moves as
smoothly as the thing does.
"""

from dataclasses import replace

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.light.frame.anchored_image import anchored_change
from magicsim.light.frame.frame_image import own_field
from magicsim.light.frame.shared_noise import REACH_PX
from magicsim.light.frame.way import UNTOUCHED, Way
from magicsim.light.passing.brought import PassingLook, brought
from magicsim.light.passing.passing_light import PassingLight
from magicsim.light.renderer import Renderer
from magicsim.light.transport.light_field import LightField
from magicsim.scenes.view import View

PARTICLES_PART = 2
"""What passes gets the strips' particles divided by this."""


class PassingRenderer(Renderer):
    """Renders views in which something passes, and others as a plain renderer does."""

    _passer: PassingLight | None = None

    def made(self, view: View) -> tuple[FloatImage, Way]:
        """Linear radiance of what is read out, shape (rows, columns, 3), with what passes in the room; how it was made.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        still, way = super().made(view)
        if view.passing_mm is None:
            return still, way
        change = self._change(self._within_reach(view), self._placed_light(view.passing_mm))
        found = np.asarray(np.maximum(still + self._film.seen(change), 0), np.float32)
        return found, Way(light="outside", image="recorded") if way == UNTOUCHED else way

    def _placed_light(self, x_mm: float) -> PassingLight:
        if self._passer is None:
            passing = self.rig.moving
            assert passing is not None
            self._passer = PassingLight(passing, self.world(View()).scene.environment(), self.rig.room_light)
        self._passer.place(x_mm)
        return self._passer

    def _change(self, view: View, light: PassingLight) -> FloatImage:
        """Change of the window of the ideal image, shape (rows, columns, 3)."""
        inner, columns, rows = self._film.window, self._film.columns, self._film.rows
        around = inner.grown(REACH_PX, columns, rows)
        pixels, shape = around.numbers(columns, rows), (around.rows, around.columns, 3)
        placed, samples = self._placed(view), self.settings.samples
        field = self._brought(view, placed, light)
        look = PassingLook(
            world=self.light(View()), outside=self._outside(placed, view.flashlight_x_mm), light=light, field=field,
            samples=samples, seed=self.seed,
        )  # fmt: skip
        before = look.through(self.careful(), pixels)
        if not self._is_moved(view, placed):
            return np.asarray(inner.within(around).of(before.reshape(shape)), np.float32)
        known, changed = look.through(self.cheap(), pixels), self._changed(view, placed, pixels)
        now = known.copy()
        if changed.any():
            traced = self.light(view).gather_pixels(field, pixels[changed], samples=samples, seed=self.seed, room=light)
            now[changed] = np.array(traced, np.float64).T
        images = [np.asarray(each.reshape(shape), np.float32) for each in (now, known, before)]
        found = anchored_change(images[0], images[1], images[2], changed.reshape(shape[:2]))
        return np.asarray(inner.within(around).of(found))

    def _brought(self, view: View, placed: Array | None, light: PassingLight) -> LightField:
        """Change of the light in the block and on the object.

        That in a touched block is that of the last state before contact: a press changes by some per cent what is some
        per cent itself.
        """
        world, careful = self.light(View()), self.careful()
        is_moved, particles = self._is_moved(view, placed), self.settings.particles
        outside = self._outside(self._free(view, placed) if is_moved else placed, view.flashlight_x_mm)
        field = brought(
            world, outside, light, own_field(world, careful), particles=max(1, particles // PARTICLES_PART),
            seed=self.seed,
        )  # fmt: skip
        if is_moved:
            world = self.light(view)
            field = replace(field, body=world.growth(careful.held_mm3) * field.body)
        return world.with_lit_object(
            field, particles=particles, seed=self.seed, outside=None if is_moved else outside, room=light
        )
