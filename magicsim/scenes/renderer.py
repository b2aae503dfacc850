"""Radiance of one sensor in any state, anchored to its untouched one, with as little work as the state needs."""

from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Self

import numpy as np

from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.anchor import Anchor
from magicsim.scenes.anchored_image import REACH_PX, anchored_image
from magicsim.scenes.anchored_light import anchored_light
from magicsim.scenes.backend import mi
from magicsim.scenes.film import film
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import total
from magicsim.scenes.plain_renderer import FloatImage, PlainRenderer, checked, lights_of
from magicsim.scenes.reach import is_out_of_reach
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.untouched import Recorded, UntouchedState, UntouchedStates, untouched_key
from magicsim.scenes.view import View
from magicsim.scenes.window import Window
from magicsim.scenes.world import World

if TYPE_CHECKING:
    from magicsim.scenes.outside import Outside, Outsides

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
        self._outsides: Outsides | None = None

    def reseeded(self, *, seed: int, anchor_seed: int) -> Self:
        """This renderer with other random numbers; both bring their views into the same Mitsuba scenes.

        Args:
            seed: Monte Carlo seed that all of its frames share.
            anchor_seed: Of its untouched state.
        """
        other = copy(self)
        other.seed = seed
        other.settings = self.settings.model_copy(update={"anchor_seed": anchor_seed})
        other._untouched, other._anchor = UntouchedStates(), None
        return other

    def radiance(self, view: View) -> FloatImage:
        """Linear radiance of what is read out, shape (rows, columns, 3), anchored if settings say so.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        if self.estimator == "path" or not self.settings.anchor_samples:
            return self.plain_radiance(view)
        view, anchor = self._within_reach(view), self.anchor()
        window = self.rig.camera.window
        if view.is_untouched:
            return np.asarray(window.of(anchor.image))
        if self._stands_free(view):
            return self._beside_anchor(view, anchor)
        world = self.world(view)
        integrator = world.scene.integrator()
        counts = self.elastomer.grid.counts if self.elastomer.grid is not None else None
        voxels = integrator.voxels.counts if integrator.voxels is not None else None
        fields = integrator.light_fields(world.scene, integrator.shares(world.scene), seed=self.seed)
        growth = _ratio(integrator.held_mm3(world.scene), anchor.held_mm3)
        known = {name: fields[name] for name in fields if name in anchor.careful}
        fields |= anchored_light(known, anchor.cheap, anchor.careful, counts, voxels, growth)
        field = total([integrator.darkness(world.scene), *fields.values()])
        image = self._gather(world, field, self.settings.samples, self.seed, read=self._wide_film)
        clean = anchored_image(image, *(self._around.of(rest) for rest in (anchor.cheap_image, anchor.image)))
        return np.asarray(window.within(self._around).of(clean))

    def _within_reach(self, view: View) -> View:
        """The view without an object that is too far to be seen."""
        placed = self._placed(view)
        if placed is None or not self.leaves_out_far:
            return view
        gap_mm, design = -float(placed[:, 2].max()), self.elastomer.design
        is_gone = is_out_of_reach(gap_mm, self.object_finish, design, self.rig, self.anchor().image)
        return replace(view, indenter=None) if is_gone else view

    def _stands_free(self, view: View) -> bool:
        is_fluence = self.estimator == "fluence" and self.elastomer.grid is not None
        camera, samples = self.rig.camera, self.settings.anchor_samples
        is_recordable = 0 < camera.columns * camera.rows * samples <= MOST_RECORDED
        if not (self.uses_records and is_fluence and is_recordable):
            return False
        if view.indenter is not None and self.object_mesh is None:
            return False
        from magicsim.scenes.approach import stands_free

        integrator = self.world(View()).scene.integrator()
        return stands_free(view, self.rig, self.object_finish, integrator, self._placed(view))

    def _outside(self, view: View) -> "Outside":
        from magicsim.scenes.outside import Outsides

        if self._outsides is None:
            self._outsides = Outsides(self.rig, self.object_mesh, self.object_finish)
        return self._outsides.of(self._placed(view), view.flashlight_x_mm)

    def _recorded(self) -> Recorded:
        """Camera paths and light of the untouched sensor."""
        from magicsim.scenes.approach import recorded

        settings = self.settings
        key = f"{self._untouched_key()} {settings.particles}"
        known = self._untouched.recorded(key)
        if known is None:
            known = recorded(
                self.world(View()).scene, seed=settings.anchor_seed, samples=settings.anchor_samples,
                particles=settings.particles,
            )  # fmt: skip
            self._untouched.keep_recorded(key, known)
        return known

    def _beside_anchor(self, view: View, anchor: Anchor) -> FloatImage:
        from magicsim.scenes.approach import seen_beside_anchor

        change = seen_beside_anchor(
            self.world(View()).scene, self._outside(view), self._recorded(), anchor, self.object_finish,
            self._film.window, samples=self.settings.samples, seed=self.seed,
        )  # fmt: skip
        image = self._film.seen(checked(change.astype(np.float32)))
        return np.asarray(np.maximum(image + self.rig.camera.window.of(anchor.image), 0))

    def metered(self) -> FloatImage:
        """The whole untouched image, which exposure is measured on, shape (rows, columns, 3)."""
        if self.estimator == "fluence" and self.settings.anchor_samples:
            return self.anchor().image
        world = self.world(View())
        return self._lit(world, lights_of(world), read=self._whole_film)

    def warm_up(self, view: View) -> None:
        """Compiles what a view of this kind needs, at a negligible number of samples."""
        if not view.is_untouched and self._stands_free(view):
            from magicsim.scenes.approach import try_out

            try_out(self.world(View()).scene, self._outside(view), self.object_finish, seed=self.seed)
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
            if not seen.is_untouched and self._stands_free(seen):
                self._recorded()

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
