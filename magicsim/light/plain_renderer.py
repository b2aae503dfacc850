"""Radiance of one sensor in any state by an estimator alone, every image for itself."""

from functools import partial

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.film import Film, film
from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import mi
from magicsim.light.facing.finger import FacingFinger
from magicsim.light.refinement import MAX_PASSES, Refinement
from magicsim.light.transport.estimator import PATHS, choose_estimator, load_world
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import World
from magicsim.light.world.loaded_scenes import Worlds
from magicsim.light.world.scene_dict import lights_off
from magicsim.scenes.near_room import flashlight_problem, object_problem
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.view import View


class PlainRenderer:
    """Owns the Mitsuba scenes of one elastomer on one rig."""

    def __init__(
        self,
        elastomer: Elastomer,
        rig: Rig,
        settings: RenderSettings,
        *,
        seed: int,
        object_mesh: SurfaceMesh | None = None,
        object_finish: Finish | None = None,
        facing: FacingFinger | None = None,
    ) -> None:
        """Prepares; scenes are loaded when a view first needs them.

        Args:
            elastomer: The block.
            rig: What surrounds it.
            settings: Estimator, samples, particles.
            seed: Monte Carlo seed that all frames share.
            object_mesh: The object in its own frame, if one will come.
            object_finish: Its surface; grey by default.
            facing: Another finger that looks back in all views but those without anything, the object before it.

        Raises:
            RenderError: The estimator cannot do what the materials ask for.
        """
        self.elastomer = elastomer
        self.rig = rig
        self.settings = settings
        self.seed = seed
        self.object_mesh = object_mesh if facing is None else facing.mesh
        self.object_finish = (object_finish or Finish()) if facing is None else facing.finish
        self._facing = facing
        self.estimator = choose_estimator(settings.estimator, elastomer, rig)
        self._film = film(elastomer.design, rig.lens, rig.camera, rig.camera.window)
        beside = facing.beside if facing is not None else (0, 0)
        self.load_world = partial(load_world, self.estimator, elastomer, rig, settings, self.object_mesh, beside)
        self._worlds = Worlds(elastomer, self.object_mesh, self.object_finish, self.load_world)

    def plain_radiance(self, view: View, *, turn: int = 0) -> FloatImage:
        """Linear radiance of a view by the estimator alone, shape (rows, columns, 3).

        Args:
            view: What to see.
            turn: Another number is an independent image of the same view.
        """
        world = self.world(view)
        return self._lit(world, world.lights, turn=turn)

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
            for name in world.lights:
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
        names, refinement = world.lights, Refinement()
        while not refinement.is_within(relative_error) and refinement.passes < MAX_PASSES:
            refinement.add(self._lit(world, names, turn=refinement.passes))
        return refinement

    def world(self, view: View) -> World:
        """The Mitsuba scene that shows a view, loaded when it is first needed.

        Raises:
            RenderError: Object or flashlight are outside of the room.
        """
        placed = self._placed(view)
        self._check_room(view, placed)
        return self._worlds.of(view, placed)

    def _check_room(self, view: View, placed: Array | None) -> None:
        if self.rig.near_mm is None:
            return
        problem = object_problem(self.rig, placed) if placed is not None else None
        if view.flashlight_x_mm is not None:
            problem = problem or flashlight_problem(self.rig, view.flashlight_x_mm)
        if problem is not None:
            raise RenderError(problem)

    def _placed(self, view: View) -> Array | None:
        """Vertices of what stands before the block in the sensor's frame [mm], or None where nothing does."""
        if self._facing is not None:
            return self._facing.placed(view)
        if view.indenter is None or self.object_mesh is None:
            return None
        return view.indenter.pose.to_sensor(self.object_mesh.vertices)

    def _lit(self, world: World, names: list[str], *, turn: int = 0, read: Film | None = None) -> FloatImage:
        """An image by some lights, others being off; every turn is independent of the others."""
        used, settings, seed = read or self._film, self.settings, self.seed + turn
        if not set(names) - set(lights_off(self.rig)):
            return used.seen(np.zeros((used.window.rows, used.window.columns, 3), np.float32))
        if isinstance(world, LitWorld):
            found = world.image(
                names, samples=settings.samples, particles=settings.particles, seed=seed, pattern=turn,
                window=used.window,
            )  # fmt: skip
        else:
            whole = mi.render(world.scene, integrator=mi.load_dict(PATHS), spp=settings.samples, seed=seed)
            found = used.window.of(np.array(whole, np.float32))
        return used.seen(checked(np.array(found, np.float32)))


def checked(image: FloatImage) -> FloatImage:
    """The image itself.

    Raises:
        RenderError: A value is not finite.
    """
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        msg = f"the rendered image holds {bad} values that are not finite"
        raise RenderError(msg)
    return image
