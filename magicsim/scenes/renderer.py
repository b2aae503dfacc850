"""Radiance of one sensor in any state, with as little work as the state needs."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.backend import VARIANT, mi
from magicsim.scenes.cell_topology import CellTopology
from magicsim.scenes.film import film
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.refinement import MAX_PASSES, Refinement
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.scenes.untouched import UntouchedState, UntouchedStates, untouched_key
from magicsim.scenes.variant import LLVM_VARIANT
from magicsim.scenes.world import INSET_MM, World, WorldContent, lights_inside

Array = npt.NDArray[np.float64]
FloatImage = npt.NDArray[np.float32]
PATH_DEPTH = 256
"""Longest path of `volpath` [interactions], roulette off; four times as long changes the mean by 0.01 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What the camera is to see. Arrays are compared by identity: pass the same array while nothing moves."""

    body: Array | None = None
    """Deformed body vertices, shape (vertices, 3) [mm]; None at rest."""
    infill: Array | None = None
    """Deformed infill vertices, shape (vertices, 3) [mm]; None at rest."""
    indenter: Indenter | None = None
    """The object where it is, or None."""
    flashlight_x_mm: float | None = None
    """Shift of the outside light [mm], or None while it is off."""

    @property
    def is_untouched(self) -> bool:
        """Whether this is the sensor alone, as the anchor holds it."""
        return self.body is None and self.infill is None and self.indenter is None and self.flashlight_x_mm is None


@dataclass(frozen=True, slots=True, kw_only=True)
class Anchor:
    """The untouched sensor, rendered cheaply with a seed and once with care.

    A frame with the same seed differs from the cheap rendering only where something changed, so adding the careful
    image and subtracting the cheap one removes the noise that all frames share (a control variate, unbiased). The
    fluence behind it is the careful one times a ratio of local means (see `LightField.anchored`): far less noisy, and
    biased only where light changes within a cell's width. The careful state has a seed of its own, the same for every
    episode: an untouched sensor always looks the same.
    """

    cheap: dict[str, LightField]
    careful: dict[str, LightField]
    cheap_image: FloatImage
    image: FloatImage


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
        self._film = film(elastomer.design, rig)
        self._whole = film(elastomer.design, rig, whole=True)
        self._worlds: dict[tuple[bool, bool], World] = {}
        self._shown: dict[int, View] = {}
        self._untouched = untouched if untouched is not None else UntouchedStates()
        self._anchor: Anchor | None = None

    def radiance(self, view: View) -> FloatImage:
        """Linear radiance of what is read out, shape (rows, columns, 3), anchored if settings say so.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        if self.estimator == "path" or not self.settings.anchor_samples:
            return self.plain_radiance(view)
        anchor = self.anchor()
        window = self.rig.camera.window
        if view.is_untouched:
            return np.asarray(window.of(anchor.image))
        world = self.world(view)
        integrator = world.scene.integrator()
        counts = self.elastomer.grid.counts if self.elastomer.grid is not None else None
        voxels = integrator.voxels.counts if integrator.voxels is not None else None
        fields = integrator.light_fields(world.scene, integrator.shares(world.scene), seed=self.seed)
        for name in fields.keys() & anchor.careful.keys():
            fields[name] = fields[name].anchored(anchor.cheap[name], anchor.careful[name], counts, voxels)
        field = total([integrator.darkness(world.scene), *fields.values()])
        image = self._gather(world, field, self.settings.samples, self.seed)
        return np.asarray(np.maximum(image - window.of(anchor.cheap_image) + window.of(anchor.image), 0))

    def metered(self) -> FloatImage:
        """The whole untouched image, which exposure is measured on, shape (rows, columns, 3)."""
        if self.estimator == "fluence" and self.settings.anchor_samples:
            return self.anchor().image
        world = self.world(View())
        return self._lit(world, _lights(world), whole=True)

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

    def _lit(self, world: World, names: list[str], *, turn: int = 0, whole: bool = False) -> FloatImage:
        """An image by some lights, others being off; every turn is independent of the others."""
        seed = self.seed + turn
        if self.estimator == "path":
            used = self._whole if whole else self._film
            image = np.array(mi.render(world.scene, spp=self.settings.samples, seed=seed), np.float32)
            return used.seen(_checked(np.asarray(used.window.of(image))))
        integrator = world.scene.integrator()
        shares = integrator.shares(world.scene)
        fields = integrator.light_fields(world.scene, {name: shares[name] for name in names}, seed=seed)
        field = total([integrator.darkness(world.scene), *fields.values()])
        return self._gather(world, field, self.settings.samples, seed, pattern=turn, whole=whole)

    def warm_up(self, view: View) -> None:
        """Compiles what a view of this kind needs, at a negligible number of samples."""
        world = self.world(view)
        if self.estimator == "path":
            mi.render(world.scene, spp=1, seed=self.seed)
            return
        integrator = world.scene.integrator()
        fields = integrator.light_fields(world.scene, dict.fromkeys(_lights(world), 64), seed=self.seed)
        self._gather(world, total([integrator.darkness(world.scene), *fields.values()]), 1, self.seed)

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
                cheap_image=self._gather(world, field, self.settings.samples, self.seed, whole=True),
                image=careful.image,
            )
        return self._anchor

    def _careful(self, world: World, names: list[str]) -> UntouchedState:
        key = untouched_key(self.elastomer.design, self.rig, self.settings)
        state = self._untouched.get(key)
        if state is None:
            integrator, seed = world.scene.integrator(), self.settings.anchor_seed
            many = max(1, self.settings.anchor_particles // max(1, len(names)))
            fields = integrator.light_fields(world.scene, dict.fromkeys(names, many), seed=seed)
            field = total([integrator.darkness(world.scene), *fields.values()])
            image = self._gather(world, field, self.settings.anchor_samples, seed, whole=True)
            state = UntouchedState(fields=fields, image=image)
            self._untouched.keep(key, state)
        return state

    def _gather(
        self, world: World, field: LightField, samples: int, seed: int, *, pattern: int = 0, whole: bool = False
    ) -> FloatImage:
        used = self._whole if whole else self._film
        image = world.scene.integrator().gather(
            world.scene, field, samples=samples, seed=seed, pattern=pattern, window=used.window
        )
        return used.seen(_checked(np.array(image, np.float32)))

    def world(self, view: View) -> World:
        """The Mitsuba scene that shows a view, loaded when it is first needed."""
        key = (view.indenter is not None, view.flashlight_x_mm is not None)
        if key not in self._worlds:
            content = WorldContent(
                object_mesh=self.object_mesh if key[0] else None,
                object_finish=self.object_finish,
                flashlight=key[1],
            )
            self._worlds[key] = World(self.elastomer, self.rig, content, self.integrator_entry())
            if self.estimator == "fluence":
                integrator = self._worlds[key].scene.integrator()
                integrator.grid.topology = CellTopology.of(self.elastomer)
                integrator.object_mesh = content.object_mesh
        world = self._worlds[key]
        self._show(world, view)
        return world

    def _show(self, world: World, view: View) -> None:
        shown = self._shown.get(id(world), View())
        moved = view.indenter is not None and (
            shown.indenter is None or shown.indenter.pose.key() != view.indenter.pose.key()
        )
        changes: dict[str, Any] = {}
        if view.body is not shown.body:
            changes["body"] = view.body if view.body is not None else self.elastomer.body.vertices
        if view.infill is not shown.infill and self.elastomer.infill is not None:
            changes["infill"] = view.infill if view.infill is not None else self.elastomer.infill.vertices
        if moved and view.indenter is not None and self.object_mesh is not None:
            changes["object_vertices"] = view.indenter.pose.to_sensor(self.object_mesh.vertices)
        if view.flashlight_x_mm is not None and view.flashlight_x_mm != (shown.flashlight_x_mm or 0.0):
            changes["light_x_mm"] = view.flashlight_x_mm
        if changes:
            world.update(**changes)
        self._shown[id(world)] = view

    def integrator_entry(self) -> dict[str, Any]:
        """The integrator's entry of a scene dictionary."""
        if self.estimator == "path":
            return {"type": "volpath", "max_depth": PATH_DEPTH, "rr_depth": PATH_DEPTH}
        import magicsim.scenes.integrator  # noqa: F401 -- registers the estimator
        from magicsim.scenes.integrator_settings import integrator_settings

        return {
            "type": "fluence",
            "particles": self.settings.particles,
            "forward_collisions": self.settings.forward_collisions,
            **integrator_settings(
                self.elastomer, self.object_finish, inside=lights_inside(self.rig), inset_mm=INSET_MM
            ),
        }


def choose_estimator(asked: str, elastomer: Elastomer, rig: Rig) -> str:
    """The estimator that will run: `fluence` needs LLVM, and falls back to `path` on the scalar variant.

    Raises:
        RenderError: The body scatters and a lens plate is bonded to it, which `path` cannot tell apart.
    """
    estimator = "path" if VARIANT != LLVM_VARIANT else asked
    if estimator == "path" and elastomer.design.materials.body.sigma_s_per_mm > 0 and rig.lens.thickness_mm > 0:
        msg = (
            f"lens.thickness_mm = {rig.lens.thickness_mm:g} is not allowed with estimator 'path' where the body "
            "scatters: must be 0; use estimator 'fluence'"
        )
        raise RenderError(msg)
    return estimator


def _lights(world: World) -> list[str]:
    from magicsim.scenes.shapes import lights

    return lights(world.scene)


def _checked(image: FloatImage) -> FloatImage:
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        msg = f"the rendered image holds {bad} values that are not finite"
        raise RenderError(msg)
    return image
