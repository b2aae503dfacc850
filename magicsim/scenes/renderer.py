"""Radiance of one sensor in any state, anchored to its untouched one, with as little work as the state needs."""

from copy import copy
from dataclasses import replace
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.anchor import Anchor
from magicsim.scenes.anchored_image import REACH_PX, anchored_image
from magicsim.scenes.anchored_light import anchored_light
from magicsim.scenes.backend import mi
from magicsim.scenes.film import film
from magicsim.scenes.finish import Finish
from magicsim.scenes.free_states import FreeStates, by_channel, lifted
from magicsim.scenes.light_field import total
from magicsim.scenes.names import FLASHLIGHT
from magicsim.scenes.plain_renderer import FloatImage, PlainRenderer, lights_of
from magicsim.scenes.reach import is_out_of_reach
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.untouched import UntouchedState, UntouchedStates, untouched_key
from magicsim.scenes.view import View
from magicsim.scenes.window import Window
from magicsim.scenes.world import World

Array = npt.NDArray[np.float64]

MOST_RECORDED = 20_000_000
"""Camera paths that are recorded at most, with two gigabytes; more of them are traced anew for each frame."""


class Renderer(PlainRenderer):
    """Owns the Mitsuba scenes of one elastomer on one rig, and the anchor of one episode."""

    def __init__(
        self,
        elastomer: Elastomer,
        rig: Rig,
        settings: RenderSettings,
        *,
        seed: int,
        object_mesh: SurfaceMesh | None = None,
        object_finish: Finish | None = None,
        untouched: UntouchedStates | None = None,
    ) -> None:
        """As `PlainRenderer`.

        Args:
            elastomer: The block.
            rig: What surrounds it.
            settings: Estimator, samples, particles.
            seed: Monte Carlo seed that all frames share.
            object_mesh: The object in its own frame, if one will come.
            object_finish: Its surface; grey by default.
            untouched: Where the sensor's untouched state is looked up and kept, for other episodes of it.
        """
        super().__init__(elastomer, rig, settings, seed=seed, object_mesh=object_mesh, object_finish=object_finish)
        self.uses_records = True
        """Whether frames in which nothing touches are made from recorded paths; otherwise in full, for comparison."""
        self.leaves_out_far = True
        """Whether an object that is too far to be seen is left out; otherwise it is rendered, for comparison."""
        camera, all_pixels = rig.camera, Window.whole(rig.camera.columns, rig.camera.rows)
        self._around = camera.window.grown(REACH_PX, camera.columns, camera.rows)
        self._wide_film, self._whole_film = (film(elastomer.design, rig, read) for read in (self._around, all_pixels))
        self._untouched = untouched if untouched is not None else UntouchedStates()
        self._anchor: Anchor | None = None
        self._free: FreeStates | None = None

    def reseeded(self, *, seed: int, anchor_seed: int) -> Self:
        """This renderer with other random numbers; both bring their views into the same Mitsuba scenes.

        Args:
            seed: Monte Carlo seed that all of its frames share.
            anchor_seed: Of its untouched state.
        """
        other = copy(self)
        other.seed = seed
        other.settings = self.settings.model_copy(update={"anchor_seed": anchor_seed})
        other._untouched, other._anchor, other._free = UntouchedStates(), None, None
        return other

    def radiance(self, view: View) -> FloatImage:
        """Linear radiance of what is read out, shape (rows, columns, 3), anchored if settings say so.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        if self.estimator == "path" or not self.settings.anchor_samples:
            return self.plain_radiance(view)
        view, anchor = self._within_reach(view), self._around_window(self.anchor())
        inner, placed = self.rig.camera.window.within(self._around), self._placed(view)
        if view.is_untouched:
            return np.asarray(inner.of(anchor.image))
        if self._stands_free(view, placed):
            return np.asarray(inner.of(self._free_states().image(placed, view.flashlight_x_mm, anchor)))
        return np.asarray(inner.of(self._touched(view, placed, anchor)))

    def _touched(self, view: View, placed: Array | None, anchor: Anchor) -> FloatImage:
        """Radiance of a view that recorded paths do not show, as it changes what its anchor shows."""
        had_free_state = self._had_free_state(view, placed)
        if had_free_state and placed is not None:
            anchor = self._free_states().anchor(placed, view.flashlight_x_mm, anchor)
        world = self.world(view)
        integrator = world.scene.integrator()
        counts = self.elastomer.grid.counts if self.elastomer.grid is not None else None
        voxels = integrator.voxels.counts if integrator.voxels is not None else None
        fields = integrator.light_fields(world.scene, integrator.shares(world.scene), seed=self.seed)
        if had_free_state:
            strips = [fields.pop(name) for name in list(fields) if name != FLASHLIGHT]
            fields |= by_channel(total([integrator.darkness(world.scene), *strips]))
        growth = _ratio(integrator.held_mm3(world.scene), anchor.held_mm3)
        known = {name: fields[name] for name in fields if name in anchor.careful}
        fields |= anchored_light(known, anchor.cheap, anchor.careful, counts, voxels, growth)
        field = total([integrator.darkness(world.scene), *fields.values()])
        image = self._gather(world, field, self.settings.samples, self.seed, read=self._wide_film)
        return anchored_image(image, anchor.cheap_image, anchor.image)

    def _around_window(self, anchor: Anchor) -> Anchor:
        """The anchor with what is read out of its images, and the neighbours that are looked at."""
        cheap_image, image = (self._around.of(whole) for whole in (anchor.cheap_image, anchor.image))
        return replace(anchor, cheap_image=cheap_image, image=image)

    def _within_reach(self, view: View) -> View:
        """The view without an object that is too far to be seen."""
        placed = self._placed(view)
        if placed is None or not self.leaves_out_far:
            return view
        gap_mm, design = -float(placed[:, 2].max()), self.elastomer.design
        is_gone = is_out_of_reach(gap_mm, self.object_finish, design, self.rig, self.anchor().image)
        return replace(view, indenter=None) if is_gone else view

    def _stands_free(self, view: View, placed: Array | None) -> bool:
        is_fluence = self.estimator == "fluence" and self.elastomer.grid is not None
        camera, samples = self.rig.camera, self.settings.anchor_samples
        is_recordable = 0 < camera.columns * camera.rows * samples <= MOST_RECORDED
        if not (self.uses_records and is_fluence and is_recordable):
            return False
        if view.indenter is not None and self.object_mesh is None:
            return False
        from magicsim.scenes.approach import stands_free

        integrator = self.world(View()).scene.integrator()
        return stands_free(view, self.rig, self.object_finish, integrator, placed)

    def _had_free_state(self, view: View, placed: Array | None) -> bool:
        """Whether the view is one of contact whose last state before it is known from recorded paths."""
        if placed is None or (view.is_undeformed and placed[:, 2].max() < 0):
            return False
        return self._stands_free(replace(view, body=None, infill=None), lifted(placed))

    def _free_states(self) -> FreeStates:
        if self._free is None:
            self._free = FreeStates(
                self.world(View()).scene, self.rig, self.settings, seed=self.seed, object_mesh=self.object_mesh,
                object_finish=self.object_finish, film=self._wide_film, untouched=self._untouched,
                key=self._untouched_key(),
            )  # fmt: skip
        return self._free

    def metered(self) -> FloatImage:
        """The whole untouched image, which exposure is measured on, shape (rows, columns, 3)."""
        if self.estimator == "fluence" and self.settings.anchor_samples:
            return self.anchor().image
        world = self.world(View())
        return self._lit(world, lights_of(world), read=self._whole_film)

    def warm_up(self, view: View) -> None:
        """Compiles what a view of this kind needs, at a negligible number of samples."""
        placed = self._placed(view)
        if not view.is_untouched and self._stands_free(view, placed):
            self._free_states().try_out(placed, view.flashlight_x_mm)
            return
        world = self.world(view)
        if self.estimator == "path":
            mi.render(world.scene, spp=1, seed=self.seed)
            return
        integrator = world.scene.integrator()
        fields = integrator.light_fields(world.scene, dict.fromkeys(lights_of(world), 64), seed=self.seed)
        self._gather(world, total([integrator.darkness(world.scene), *fields.values()]), 1, self.seed)

    def prepare(self, view: View) -> None:
        """Computes what all frames like this one share: the untouched sensor, and its camera paths where they serve."""
        if self.estimator == "fluence" and self.settings.anchor_samples:
            self.anchor()
            seen = self._within_reach(view)
            placed = self._placed(seen)
            touches = self._had_free_state(seen, placed)
            if touches or (not seen.is_untouched and self._stands_free(seen, placed)):
                self._free_states().careful()
            if touches:
                self._free_states().cheap()

    def anchor(self) -> Anchor:
        """The untouched state of this episode, computed once."""
        if self._anchor is None:
            key = f"{self._untouched_key()} {self.settings.samples} {self.settings.particles} {self.seed}"
            self._anchor = self._untouched.anchor(key)
            if self._anchor is None:
                self._anchor = self._new_anchor()
                self._untouched.keep_anchor(key, self._anchor)
        return self._anchor

    def _new_anchor(self) -> Anchor:
        world = self.world(View())
        integrator, names = world.scene.integrator(), lights_of(world)
        cheap = integrator.light_fields(world.scene, integrator.shares(world.scene), seed=self.seed)
        careful = self._careful(world, names)
        field = total([integrator.darkness(world.scene), *careful.fields.values()])
        return Anchor(
            cheap=cheap,
            careful=careful.fields,
            cheap_image=self._gather(world, field, self.settings.samples, self.seed, read=self._whole_film),
            image=careful.image,
            held_mm3=integrator.held_mm3(world.scene),
        )

    def _untouched_key(self) -> str:
        return untouched_key(self.elastomer.design, self.rig, self.settings)

    def _careful(self, world: World, names: list[str]) -> UntouchedState:
        key = self._untouched_key()
        state = self._untouched.get(key)
        if state is None:
            integrator, seed = world.scene.integrator(), self.settings.anchor_seed
            many = max(1, self.settings.anchor_particles // max(1, len(names)))
            fields = integrator.light_fields(world.scene, dict.fromkeys(names, many), seed=seed)
            field = total([integrator.darkness(world.scene), *fields.values()])
            image = self._gather(world, field, self.settings.anchor_samples, seed, read=self._whole_film)
            state = UntouchedState(fields=fields, image=image)
            self._untouched.keep(key, state)
        return state


def _ratio(now: np.ndarray, before: np.ndarray) -> np.ndarray:
    """What is 0 before stays 0."""
    return np.asarray(np.divide(now, before, out=np.zeros_like(now), where=before > 0))
