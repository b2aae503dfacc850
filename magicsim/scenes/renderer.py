"""Radiance of one sensor in any state, with as little work as the state needs."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.anchor import Anchor
from magicsim.scenes.backend import mi
from magicsim.scenes.estimator import choose_estimator, integrator_entry
from magicsim.scenes.film import Film, film
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.reach import is_out_of_reach
from magicsim.scenes.refinement import MAX_PASSES, Refinement
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.shared_noise import REACH_PX, without_shared_noise
from magicsim.scenes.untouched import Recorded, UntouchedState, UntouchedStates, untouched_key
from magicsim.scenes.view import View
from magicsim.scenes.window import Window
from magicsim.scenes.world import World
from magicsim.scenes.worlds import Worlds

if TYPE_CHECKING:
    from magicsim.scenes.outside import Outside, Outsides

Array = npt.NDArray[np.float64]
FloatImage = npt.NDArray[np.float32]


class Renderer:
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
        """Prepares; scenes are loaded when a view first needs them.

        Args:
            elastomer: The block.
            rig: What surrounds it.
            settings: Estimator, samples, particles.
            seed: Monte Carlo seed that all frames share.
            object_mesh: The object in its own frame, if one will come.
            object_finish: Its surface; grey by default.
            untouched: Where the sensor's untouched state is looked up and kept, for other episodes of it.

        Raises:
            RenderError: The estimator cannot do what the materials ask for.
        """
        self.elastomer = elastomer
        self.rig = rig
        self.settings = settings
        self.seed = seed
        self.object_mesh = object_mesh
        self.object_finish = object_finish or Finish()
        self.estimator = choose_estimator(settings.estimator, elastomer, rig)
        self.uses_records = True
        """Whether frames in which nothing touches are made from recorded paths; otherwise in full, for comparison."""
        self.leaves_out_far = True
        """Whether an object that is too far to be seen is left out; otherwise it is rendered, for comparison."""
        camera, all_pixels = rig.camera, Window.whole(rig.camera.columns, rig.camera.rows)
        self._around = camera.window.grown(REACH_PX, camera.columns, camera.rows)
        self._film, self._wide_film, self._whole_film = (
            film(elastomer.design, rig, read) for read in (camera.window, self._around, all_pixels)
        )
        self._worlds: Worlds | None = None
        self._untouched = untouched if untouched is not None else UntouchedStates()
        self._anchor: Anchor | None = None
        self._outsides: Outsides | None = None

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
        for name in fields.keys() & anchor.careful.keys():
            fields[name] = fields[name].anchored(anchor.cheap[name], anchor.careful[name], counts, voxels)
        field = total([integrator.darkness(world.scene), *fields.values()])
        image = self._gather(world, field, self.settings.samples, self.seed, read=self._wide_film)
        clean = without_shared_noise(image, *(self._around.of(rest) for rest in (anchor.cheap_image, anchor.image)))
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
        if not (self.uses_records and is_fluence and self.settings.anchor_samples):
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

    def _placed(self, view: View) -> Array | None:
        """Vertices of the object in the sensor's frame [mm], or None where there is none."""
        if view.indenter is None or self.object_mesh is None:
            return None
        return view.indenter.pose.to_sensor(self.object_mesh.vertices)

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
        image = self._film.seen(_checked(change.astype(np.float32)))
        return np.asarray(np.maximum(image + self.rig.camera.window.of(anchor.image), 0))

    def metered(self) -> FloatImage:
        """The whole untouched image, which exposure is measured on, shape (rows, columns, 3)."""
        if self.estimator == "fluence" and self.settings.anchor_samples:
            return self.anchor().image
        world = self.world(View())
        return self._lit(world, _lights(world), read=self._whole_film)

    def plain_radiance(self, view: View, *, turn: int = 0) -> FloatImage:
        """Linear radiance of a view by the estimator alone, shape (rows, columns, 3).

        Args:
            view: What to see.
            turn: Another number is an independent image of the same view.
        """
        world = self.world(view)
        return self._lit(world, _lights(world), turn=turn)

    def basis(self, view: View, *, turn: int = 0) -> dict[str, FloatImage]:
        """One linear radiance image for each light that a view has, each of shape (rows, columns, 3).

        Rendering is linear in the lights and all images share their random numbers: those of `plain_radiance` are their
        sum, and other strengths or colours of the lights a weighted one (see `relight`).

        Args:
            view: What to see.
            turn: Another number gives independent images of the same view.
        """
        world, images = self.world(view), {}
        try:
            for name in _lights(world):
                world.light_only(name)
                images[name] = self._lit(world, [name], turn=turn)
        finally:
            world.light_only(None)
        return images

    def refined(self, view: View, relative_error: float) -> Refinement:
        """Independent images of a view until their mean is as good as asked for, or `MAX_PASSES` have been taken.

        Args:
            view: What to see.
            relative_error: Root mean square error over pixels and channels in units of the mean, see `Refinement`.
        """
        world = self.world(view)
        names, refinement = _lights(world), Refinement()
        while not refinement.is_within(relative_error) and refinement.passes < MAX_PASSES:
            refinement.add(self._lit(world, names, turn=refinement.passes))
        return refinement

    def _lit(self, world: World, names: list[str], *, turn: int = 0, read: Film | None = None) -> FloatImage:
        """An image by some lights, others being off; every turn is independent of the others."""
        seed = self.seed + turn
        if self.estimator == "path":
            used = read or self._film
            image = np.array(mi.render(world.scene, spp=self.settings.samples, seed=seed), np.float32)
            return used.seen(_checked(np.asarray(used.window.of(image))))
        integrator = world.scene.integrator()
        shares = integrator.shares(world.scene)
        fields = integrator.light_fields(world.scene, {name: shares[name] for name in names}, seed=seed)
        field = total([integrator.darkness(world.scene), *fields.values()])
        return self._gather(world, field, self.settings.samples, seed, pattern=turn, read=read)

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
        fields = integrator.light_fields(world.scene, dict.fromkeys(_lights(world), 64), seed=self.seed)
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
            world = self.world(View())
            integrator, names = world.scene.integrator(), _lights(world)
            cheap = integrator.light_fields(world.scene, integrator.shares(world.scene), seed=self.seed)
            careful = self._careful(world, names)
            field = total([integrator.darkness(world.scene), *careful.fields.values()])
            self._anchor = Anchor(
                cheap=cheap,
                careful=careful.fields,
                cheap_image=self._gather(world, field, self.settings.samples, self.seed, read=self._whole_film),
                image=careful.image,
            )
        return self._anchor

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

    def _gather(
        self, world: World, field: LightField, samples: int, seed: int, *, pattern: int = 0, read: Film | None = None
    ) -> FloatImage:
        used = read or self._film
        image = world.scene.integrator().gather(
            world.scene, field, samples=samples, seed=seed, pattern=pattern, window=used.window
        )
        return used.seen(_checked(np.array(image, np.float32)))

    def world(self, view: View) -> World:
        """The Mitsuba scene that shows a view, loaded when it is first needed."""
        if self._worlds is None:
            self._worlds = Worlds(
                self.elastomer, self.rig, self.object_mesh, self.object_finish, self.integrator_entry()
            )
        return self._worlds.of(view, self._placed(view))

    def integrator_entry(self) -> dict[str, Any]:
        """The integrator's entry of a scene dictionary."""
        return integrator_entry(self.estimator, self.elastomer, self.rig, self.settings, self.object_finish)


def _lights(world: World) -> list[str]:
    from magicsim.scenes.shapes import lights

    return lights(world.scene)


def _checked(image: FloatImage) -> FloatImage:
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        msg = f"the rendered image holds {bad} values that are not finite"
        raise RenderError(msg)
    return image
