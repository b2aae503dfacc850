"""Radiance of one sensor in any state by an estimator alone, every image for itself."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.film import Film, film
from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import VARIANT, mi, plain_errors
from magicsim.light.facing.finger import FacingFinger
from magicsim.light.records.untouched import UntouchedStates, default_store
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.variant import SCALAR_VARIANT
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import World, Worlds
from magicsim.light.world.scene_dict import WorldContent, lights_off
from magicsim.scenes.refusals import flashlight_problem, object_problem
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.timeline import View

LEAST_PASSES = 4
"""Images below which their spread says little: with four the estimate is within some per cent, over so many pixels."""
MAX_PASSES = 4096
BORDER_PX, BORDER_SHARE = 30, 4
"""Edge that the error leaves out: so many pixels, or one in so many of a small image."""
PATH_DEPTH = 256
"""Longest path of `volpath` [interactions], roulette off; four times as long changes the mean by 0.01 %."""
PATHS = {"type": "volpath", "max_depth": PATH_DEPTH, "rr_depth": PATH_DEPTH}
"""Mitsuba's path tracer, as an entry of its dictionaries."""


@dataclass(slots=True)
class Refinement:
    """Images so far; the error is that of their mean.

    The error is the root mean square over pixels and channels of the central image, over the mean there. It knows what
    changes from image to image, noise and aliasing, but no bias that all of them share.
    """

    passes: int = 0
    _sum: Array = field(default_factory=lambda: np.zeros(0))
    _squares: Array = field(default_factory=lambda: np.zeros(0))

    def add(self, image: FloatImage) -> None:
        """Takes one more image, shape (rows, columns, 3)."""
        now = image.astype(np.float64)
        self._sum, self._squares = (now, now**2) if self.passes == 0 else (self._sum + now, self._squares + now**2)
        self.passes += 1

    @property
    def image(self) -> FloatImage:
        """The mean, shape (rows, columns, 3)."""
        return np.asarray(self._sum / self.passes, np.float32)

    @property
    def relative_error(self) -> float:
        """Relative error of the mean; infinite before there is any spread to judge it by."""
        if self.passes < LEAST_PASSES:
            return float("inf")
        mean = self._sum / self.passes
        variance = (self._squares / self.passes - mean**2) / (self.passes - 1)
        size = float(central(mean).mean())
        return float(np.sqrt(max(central(variance).mean(), 0.0))) / size if size > 0 else 0.0

    def is_within(self, relative_error: float) -> bool:
        """Whether the mean is as good as asked for."""
        return self.relative_error <= relative_error


def central(image: Array) -> Array:
    """The image without its edges."""
    cut = [min(BORDER_PX, size // BORDER_SHARE) for size in image.shape[:2]]
    return image[cut[0] : image.shape[0] - cut[0], cut[1] : image.shape[1] - cut[1]]


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
        untouched: UntouchedStates | None = None,
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
            untouched: Where the sensor's untouched state is looked up and kept, for other episodes of it.
            facing: Another finger that looks back, with the object before it; see `Renderer.facing_another`.
        """
        self.elastomer = elastomer
        self.rig = rig
        self.settings = settings
        self.seed = seed
        self.object_mesh = object_mesh if facing is None else facing.mesh
        self.object_finish = (object_finish or Finish()) if facing is None else facing.finish
        self._facing, self._untouched = facing, untouched or UntouchedStates(default_store())
        self.estimator = choose_estimator(settings.estimator, elastomer, rig)
        self.film = film(elastomer.design, rig.lens, rig.camera, rig.camera.window)
        if self.estimator == "path":
            self.load_world: Callable[[WorldContent], World] = partial(World, elastomer, rig)
        else:
            self.load_world = partial(
                LitWorld, elastomer, rig, forward_collisions=settings.forward_collisions, own_mesh=self.object_mesh,
                beside=facing.beside if facing is not None else (0, 0),
            )  # fmt: skip
        self._worlds = Worlds(elastomer, self.object_mesh, self.object_finish, self.load_world)

    def plain_radiance(self, view: View, *, turn: int = 0) -> FloatImage:
        """Linear radiance of a view by the estimator alone, shape (rows, columns, 3)."""
        world = self.world(view)
        return self._lit(world, world.lights, turn=turn)

    def basis(self, view: View, *, turn: int = 0) -> dict[str, FloatImage]:
        """One linear radiance image for each light that a view has, each of shape (rows, columns, 3).

        Rendering is linear in the lights and all images share their random numbers: those of `plain_radiance` are their
        sum, and other strengths or colours of the lights a weighted one (see `relight`).
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
        """Independent images of a view until their mean has this error (see `Refinement`), or `MAX_PASSES` of them."""
        world = self.world(view)
        names, refinement = world.lights, Refinement()
        while not refinement.is_within(relative_error) and refinement.passes < MAX_PASSES:
            refinement.add(self._lit(world, names, turn=refinement.passes))
        return refinement

    def world(self, view: View) -> World:
        """The scene of a view, loaded when first needed; `RenderError` where something is outside of the room."""
        placed = self.placed(view)
        self.check_room(view, placed)
        return self._worlds.of(view, placed)

    def check_room(self, view: View, placed: Array | None) -> None:
        """`RenderError` where the object or the flashlight of a view is outside of the room."""
        if self.rig.near_mm is None:
            return
        problem = object_problem(self.rig, placed) if placed is not None else None
        if view.flashlight_x_mm is not None:
            problem = problem or flashlight_problem(self.rig, view.flashlight_x_mm)
        if problem is not None:
            raise RenderError(problem)

    def placed(self, view: View) -> Array | None:
        """Vertices of what stands before the block in the sensor's frame [mm], or None where nothing does."""
        if self._facing is not None:
            return self._facing.placed(view)
        if view.indenter is None or self.object_mesh is None:
            return None
        return view.indenter.pose.to_sensor(self.object_mesh.vertices)

    @plain_errors()
    def _lit(self, world: World, names: list[str], *, turn: int = 0, read: Film | None = None) -> FloatImage:
        """An image by some lights, others being off; every turn is independent of the others."""
        used, settings, seed = read or self.film, self.settings, self.seed + turn
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
    """The image itself; `RenderError` where a value is not finite."""
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        raise RenderError(f"the rendered image holds {bad} values that are not finite")
    return image


def choose_estimator(asked: str, elastomer: Elastomer, rig: Rig) -> str:
    """The estimator that will run: `fluence` needs LLVM or CUDA, and falls back to `path` on the scalar variant.

    `RenderError` where the body scatters and a lens plate is bonded to it, which `path` cannot tell apart.
    """
    estimator = "path" if VARIANT == SCALAR_VARIANT else asked
    if estimator == "path" and elastomer.design.materials.body.sigma_s_per_mm > 0 and rig.lens.thickness_mm > 0:
        raise RenderError(
            f"lens.thickness_mm = {rig.lens.thickness_mm:g} is not allowed with estimator 'path' where the body "
            "scatters: must be 0; use estimator 'fluence'"
        )
    return estimator
