"""Radiance of one sensor untouched, made once for all its frames: what they are anchored to and exposed on."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.camera.camera import Window
from magicsim.camera.film import Film, film
from magicsim.light.backend import plain_errors
from magicsim.light.frame.frame_image import room_part
from magicsim.light.plain_renderer import PlainRenderer
from magicsim.light.records.untouched import RECORDED_PARTS, Made, Untouched, untouched_key
from magicsim.light.records.untouched_passes import untouched
from magicsim.light.transport.light_starts import ROOM_PART
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.path_record import Regions
from magicsim.light.world.names import ENVIRONMENT
from magicsim.scenes.scene import RECORDED_SAMPLES
from magicsim.scenes.timeline import View

MOST_RECORDED = 20_000_000
"""Camera paths that are recorded at most, with two gigabytes: of a larger image fewer a pixel."""


class RestRenderer(PlainRenderer):
    """Owns the untouched states of one elastomer on one rig."""

    def of_sensor(self, kind: str, make: Callable[[], Made], *, of: str = "") -> Made:
        """What all episodes of this sensor share, made by the first that asks; several of a kind differ by `of`."""
        return self._untouched.made(kind, f"{self._key} {self.rig.camera.region_px} {of}", make)

    def arrays_of_sensor(self, kind: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Arrays that the untouched sensor alone decides, on disk, or made and kept there."""
        return self._untouched.arrays(f"{self._key} {kind}", make)

    @plain_errors()
    def room_radiance(self) -> FloatImage | None:
        """What the room's light makes of the untouched image, shape (rows, columns, 3), by its recorded paths.

        None where no paths are recorded, or none of them serves.
        """
        if not self.is_anchored or self.elastomer.design.is_opaque:
            return None
        film, pixels = self.film, self.film.window.numbers(self.film.columns, self.film.rows)
        shape = (film.window.rows, film.window.columns, 3)
        return film.seen(
            self.of_sensor("room", lambda: room_part(self.light(View()), self.anchor(), pixels).reshape(shape))
        )

    @plain_errors()
    def metered(self) -> FloatImage:
        """The whole untouched image, which exposure is measured on, shape (rows, columns, 3)."""
        if self.is_anchored:
            return self._whole_film.seen(np.asarray(self._whole_film.window.of(self.anchor().image)))
        world = self.world(View())
        return self._lit(world, world.lights, read=self._whole_film)

    @cached_property
    def _whole_film(self) -> Film:
        rig, camera = self.rig, self.rig.camera
        return film(self.elastomer.design, rig.lens, camera, Window.whole(camera.columns, camera.rows))

    def anchor(self) -> Untouched:
        """The untouched sensor with many samples, computed once."""
        settings, key = self.settings, self._key
        state = self._untouched.get(key, on_disk=True)
        if state is None:
            world = self.light(View())
            each = max(1, settings.anchor_particles // max(1, len(world.lights)))
            particles = {name: max(1, each // ROOM_PART) if name == ENVIRONMENT else each for name in world.lights}
            state = untouched(
                world, particles, seed=settings.anchor_seed, samples=settings.anchor_samples,
                most=min(self._most, RECORDED_SAMPLES), recorded=each // RECORDED_PARTS,
            )  # fmt: skip
            self._untouched.keep(key, state, on_disk=True)
        return state

    def control(self) -> Untouched:
        """The untouched sensor with the samples, particles and random numbers of a frame, computed once."""
        settings, most = self.settings, self._most
        key = f"{self._key} {settings.samples} {settings.particles} {self.seed}"
        state = self._untouched.get(key)
        if state is None:
            world, vertices = self.light(View()), self.elastomer.body.vertices
            particles = world.shares(settings.particles)
            state = untouched(
                world, particles, seed=self.seed, samples=min(settings.samples, most), most=most,
                recorded=max(particles.values(), default=0), with_room=True,
                regions=Regions.of(vertices.min(0), vertices.max(0), self.film.columns * self.film.rows),
            )  # fmt: skip
            self._untouched.keep(key, state)
        return state

    @property
    def _key(self) -> str:
        return untouched_key(self.elastomer.design, self.rig, self.settings)

    @property
    def _most(self) -> int:
        return max(1, MOST_RECORDED // (self.film.columns * self.film.rows))

    def light(self, view: View) -> LitWorld:
        """The scene that shows a view, and the light in it."""
        world = self.world(view)
        assert isinstance(world, LitWorld)  # what is anchored is no path tracer's
        return world

    @property
    def is_anchored(self) -> bool:
        """Whether frames refer to the untouched sensor: the path tracer's stand alone."""
        return self.estimator == "fluence" and self.settings.anchor_samples > 0
