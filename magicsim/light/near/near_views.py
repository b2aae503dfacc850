"""Which views of a sensor compressed transport shows, and what they share from one to the next."""

from dataclasses import dataclass, field

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.light.backend import VARIANT, plain_errors
from magicsim.light.near.lamp_light import LampLight
from magicsim.light.near.near_object import NearObject
from magicsim.light.near.near_transport import NearTransport, follow_ports
from magicsim.light.plain_renderer import checked
from magicsim.light.renderer import Renderer
from magicsim.light.variant import CUDA_VARIANT
from magicsim.scenes.timeline import View

LAMP_PARTICLES = 4
"""Times the strips' particles that a flashlight in one place gets once, for all frames."""


@dataclass(slots=True)
class NearViews:
    """Views in which nothing touches, by compressed transport: of object, flashlight, what passes."""

    renderer: Renderer
    _object: NearObject | None = field(default=None, init=False)

    @plain_errors()
    def radiance(self, view: View) -> FloatImage | None:
        """Linear radiance of what is read out, shape (rows, columns, 3); None for views of another kind.

        Faster than the renderer's, and as exact (`benchmarks/frame_error.py --tiers true,fast`).

        Raises:
            RenderError: The image holds values that are not finite.
        """
        renderer, finish = self.renderer, self.renderer.object_finish
        shown = renderer.within_reach(view)
        placed, light_x_mm = renderer.placed(shown), shown.flashlight_x_mm
        if shown.facing_mm is not None or shown.companion is not None or renderer.is_moved(shown, placed):
            return None
        if not renderer.is_anchored or renderer.elastomer.design.is_opaque or finish.is_ghost:
            return None
        # What a mirror shows needs two scenes at once, and `NearObject.matt` knows one colour.
        if finish.specular > 0 and (VARIANT == CUDA_VARIANT or finish.vertex_colors):
            return None
        if placed is None and light_x_mm is None and view.passing_mm is None:
            return None
        lamp_mm = renderer.rig.flashlight.distance_mm
        if placed is not None and light_x_mm is not None and placed[:, 2].max() < -lamp_mm:
            return None  # behind the flashlight
        renderer.check_room(shown, placed)
        renderer.light(View())  # a dent may have been shown in it
        transport = renderer.of_sensor("near", self._transport)
        lamp = self._lamp_light(transport, light_x_mm) if light_x_mm is not None else None
        passing = renderer.passing_light(view.passing_mm) if view.passing_mm is not None else None
        film = renderer.film
        pixels = film.window.numbers(film.columns, film.rows)
        image = transport.image(self._placed_object(shown), pixels, seed=renderer.seed, lamp=lamp, passing=passing)
        return film.seen(checked(image.reshape(film.window.rows, film.window.columns, 3).astype(np.float32)))

    def _transport(self) -> NearTransport:
        world = self.renderer.light(View())
        followed = self.renderer.arrays_of_sensor("ports", lambda: follow_ports(world))
        return NearTransport.of(world, self.renderer.anchor(), followed)

    def _placed_object(self, view: View) -> NearObject | None:
        """The object of a view, in its place."""
        if view.indenter is None or self.renderer.object_mesh is None:
            return None
        if self._object is None:
            self._object = NearObject.of(self.renderer.object_mesh, self.renderer.object_finish)
        self._object.place(view.indenter.pose)
        return self._object

    def _lamp_light(self, transport: NearTransport, light_x_mm: float) -> LampLight:
        """Light of the flashlight in one place in the untouched sensor."""
        renderer, lamp = self.renderer, self.renderer.rig.flashlight
        outside = renderer.outside(None, light_x_mm)
        return renderer.of_sensor(
            "flashlight", lambda: LampLight.of(
                transport.world, transport.rest.paths, outside, transport.into, transport.brought, lamp=lamp,
                light_x_mm=light_x_mm, particles=LAMP_PARTICLES * renderer.settings.particles,
                seed=renderer.settings.anchor_seed,
            ), of=f"{lamp!r} {light_x_mm} {renderer.settings.particles}",
        )  # fmt: skip
