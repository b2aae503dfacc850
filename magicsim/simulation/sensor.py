"""One sensor: geometry, lattice and renderer, asked for deformations and images of single states."""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage
from magicsim.camera.exposure import check_codec, meter
from magicsim.camera.stream import CameraStream
from magicsim.deform.contact.face import POINT_SPACING_MM, point_spacing_mm
from magicsim.deform.deformation import Deformation, Displacement
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.follow import FollowMap, follow_map
from magicsim.deform.lattice.relaxation import Branches, body_branches
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.quality import SOLVE_QUALITIES
from magicsim.deform.solve.factorise import on_one_blas_thread
from magicsim.deform.solve.load_step import is_there
from magicsim.deform.solve.path import ContactSolver, taken_away
from magicsim.errors import ConfigError, RenderError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import Elastomer, build_elastomer
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.limits import LimitsWatch
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.geometry.pose import Pose
from magicsim.light.records.untouched import UntouchedStates
from magicsim.light.renderer import Renderer
from magicsim.light.world.finish import Finish
from magicsim.scenes.refusals import sensor_refusal
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import ContactSettings, RenderSettings, SceneConfig, TaxelSettings
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin, View, placed_in, timeline
from magicsim.simulation.emulation import Emulation
from magicsim.simulation.meshes import Meshes, attach_meshes, check_walls, deformed_vertices, marker_map
from magicsim.simulation.touch_truth import TouchTruth

AWAY_MM = 5.0
"""Gap at which an object counts that is gone, while a dent recovers [mm]."""
STEP_S = 1 / 15
"""Time between states of a sensor that has no frame rate [s]."""


class Sensor:
    """One sensor: solves and renders states on request, reusing what has not changed."""

    def __init__(
        self, design: ElastomerDesign, rig: Rig, target: ObjectBase | None = None, *,
        contact: ContactSettings | None = None, render: RenderSettings | None = None,
        states: Sequence[FrameState] = (), seed: int = 0, step_s: float = STEP_S,
        untouched: UntouchedStates | None = None, companion: SurfaceMesh | None = None,
        opposite: "Callable[[], Sensor | None] | None" = None,
    ) -> None:  # fmt: skip
        """Builds geometry, lattice and renderer.

        Args:
            design: The block.
            rig: What surrounds it.
            target: The object that may come.
            contact: How skin and object meet.
            render: How radiance is computed.
            states: Where the object may touch: the lattice is as fine there as the design's, coarser elsewhere. Without
                any it is as fine everywhere.
            seed: Of everything random in rendering.
            step_s: Time from one state to the next, for a body that relaxes [s].
            untouched: Untouched states of sensors that other episodes share.
            companion: What may be seen beside the object and touches nothing, with colours, in its own frame; only in
                views with a facing finger.
            opposite: Gives the sensor that may face this one, once a view shows it; by default, and for None, this.

        Raises:
            ConfigError: No image can be made of such a sensor, or the camera's codec is not installed.
            GeometryError: The design cannot be built.
            RenderError: The estimator cannot render these materials.
        """
        check_codec(rig.camera.compression)
        self.design, self.rig, self.object = design, rig, target
        self.contact, self.settings = contact or ContactSettings(), render or RenderSettings()
        problem = sensor_refusal(design, rig, is_recorded=self.settings.is_recorded)
        if problem is not None:
            raise ConfigError(problem)
        self.states, self.seed, self.step_s = tuple(states), seed, step_s
        self.limits = LimitsWatch(design.limits)
        """Warns once of what the print may not bear; shared by all copies of this sensor."""
        self.elastomer: Elastomer = build_elastomer(design, facet_mm=self.settings.facet_mm)
        self._solve = SOLVE_QUALITIES[self.contact.quality]
        self.lattice: Lattice = weakened(build_lattice(self._solve.of(design), zone=self._zone()), self.contact.failure)
        """The lattice that is solved: as fine where the object can touch, coarser elsewhere."""
        self.markers = marker_map(design, self.lattice)
        self.renderer = self._build_renderer(untouched)
        self._facing: Renderer | None = None
        self.emulation = Emulation()
        """What is emulated, where that is asked for."""
        self.companion = companion
        """What may be seen beside the object."""
        self._opposite = opposite
        self.known: Deformation | None = None
        """An equilibrium of this sensor, reached from rest, that was solved before: a press to it takes no solve."""
        self._solver: ContactSolver | None = None
        self.rest = Deformation.rest(self.lattice)

    @classmethod
    def for_scene(
        cls, scene: SceneConfig, *, states: Sequence[FrameState] | None = None,
        untouched: UntouchedStates | None = None,
        companion: SurfaceMesh | None = None, opposite: "Callable[[], Sensor | None] | None" = None,
    ) -> Self:  # fmt: skip
        """The sensor of a scene, fine where the scene's object touches.

        Args:
            scene: What happens.
            states: Where the object may touch, in place of the scene's own states.
            untouched: Untouched states of sensors that other episodes share.
            companion: See the sensor itself.
            opposite: See the sensor itself.

        Raises:
            MagicsimError: As the sensor itself.
        """
        return cls(
            scene.design, scene.rig, scene.object, contact=scene.contact, render=scene.render,
            states=timeline(scene) if states is None else states, seed=scene.seed, step_s=1 / scene.frames_per_second,
            untouched=untouched, companion=companion, opposite=opposite,
        )  # fmt: skip

    @cached_property
    def printed(self) -> Lattice:
        """All planes of the design's lattice, which the displacements of an episode refer to."""
        return build_lattice(self.design)

    @cached_property
    def _printed_nodes(self) -> FollowMap:
        return follow_map(self.lattice, self.printed.nodes_mm)

    @cached_property
    def meshes(self) -> Meshes:
        """Vertices of the block as the lattice carries them."""
        return attach_meshes(self.elastomer, self.lattice)

    def _zone(self) -> Zone | None:
        """Where the object may touch."""
        placed = [self.indenter(state) for state in self.states if state.can_touch]
        return contact_zone([indenter for indenter in placed if indenter is not None], self.design)

    def reseeded(self, turn: int) -> Self:
        """This sensor with other random numbers; geometry, lattice and Mitsuba scenes are shared.

        Args:
            turn: What is added to the seed and to that of the untouched state.
        """
        other = copy(self)
        other.seed = self.seed + turn
        other.settings = self.settings.model_copy(update={"anchor_seed": self.settings.anchor_seed + turn})
        other.renderer = self.renderer.reseeded(seed=other.seed, anchor_seed=other.settings.anchor_seed)
        other._facing, other.emulation = None, Emulation()
        return other

    def with_rig(self, rig: Rig, *, design: ElastomerDesign | None = None, is_alike: bool = False) -> Self:
        """This sensor in another rig; geometry and lattice are shared.

        Args:
            rig: What surrounds it then.
            design: Another print of the block, which differs by what light alone sees: indices, roughness, inclusions.
            is_alike: Whether only what comes after the radiance differs, such as exposure: nothing is rendered anew.
        """
        other = copy(self)
        other.rig = rig
        if design is not None:
            other.design, other.elastomer = design, build_elastomer(design, facet_mm=self.settings.facet_mm)
        if not is_alike:
            other.renderer, other._facing, other.emulation = other._build_renderer(None), None, Emulation()
        return other

    @property
    def opposite(self) -> "Sensor | None":
        """The sensor that may face this one, None where it is one like this."""
        return self._opposite() if self._opposite is not None else None

    def _build_renderer(self, untouched: UntouchedStates | None) -> Renderer:
        surface, finish = None, None
        if self.object is not None:
            surface = self.object.surface()
            finish = Finish.of(self.object, surface)
        return Renderer(
            self.elastomer, self.rig, self.settings, seed=self.seed, object_mesh=surface, object_finish=finish,
            untouched=untouched,
        )  # fmt: skip

    def warm_up(self, states: Sequence[FrameState]) -> None:
        """Compiles every kernel that some states need, so that the frames themselves are timed without it."""
        if any(state.can_touch for state in states):
            compile_kernels()
        kinds = {(state.has_object, state.flashlight): state for state in (UNTOUCHED, *states)}
        for state in kinds.values():
            self.renderer.warm_up(self.view(state, self.rest))

    def indenter(self, state: FrameState) -> Indenter | None:
        """The object as placed by a state."""
        return placed_in(state, self.object, self.design)

    def deform(self, state: FrameState, previous: Deformation) -> Deformation:
        """Equilibrium for a state in which contact is possible, warm-started from the previous one.

        The previous one itself where the object has not moved since, and nothing relaxes.

        `ConvergenceError` where no valid equilibrium was found, `RenderError` where walls have torn.
        """
        recovers = self.contact.keeps_dent and not previous.is_rest
        indenter = self.indenter(state if state.has_object or not recovers else replace(state, gap_mm=AWAY_MM))
        if indenter is None:
            return self.rest
        if not state.has_object and previous.pose is not None:
            indenter = taken_away(replace(indenter, pose=previous.pose))
        if not self.contact.rate_dependent:
            known = self.known if previous.is_rest else previous
            if known is not None and is_there(indenter, known):
                return known
        if self._solver is None:
            self._solver = ContactSolver(
                self.lattice, options=self._solve.newton, friction=self.contact.friction,
                point_spacing_mm=point_spacing_mm(indenter.shape), branches=self._branches(),
                recovers=self.contact.recovers, core=CoreLaw.of(self.design, self.lattice, self.contact.failure),
                max_iterations=self.contact.max_iterations,
            )  # fmt: skip
        start = previous if not previous.is_rest else None
        found = self._solver.solve(indenter, start, dt_s=self.step_s)
        if found.core is not None and (torn := int(found.core.torn.sum())):
            raise RenderError(
                f"walls of {torn} printed cells have torn (contact.wall_tear_elongation = "
                f"{self.contact.wall_tear_elongation:g}), which no image shows: press less deep, or use magicsim press"
            )
        return found

    def printed_displacements_mm(self, deformation: Deformation) -> npt.NDArray[np.float32]:
        """Displacements of all nodes of the design's lattice, shape (printed nodes, 3) [mm]."""
        moved = self._printed_nodes.displaced(deformation.displacements_mm) - self.printed.nodes_mm
        return moved.astype(np.float32)

    def touch_truth(self, settings: TaxelSettings) -> TouchTruth:
        """What tells the fields of touch of this sensor's deformations.

        Args:
            settings: Which taxels, and what of them.
        """
        spacing_mm = point_spacing_mm(self.object.shape()) if self.object is not None else POINT_SPACING_MM
        return TouchTruth.of(
            self.design, self.lattice, settings, point_spacing_mm=spacing_mm, branches=self._branches()
        )

    def _branches(self) -> Branches | None:
        return body_branches(self.design, self.lattice) if self.contact.rate_dependent else None

    def markers_mm(self, deformation: Deformation | Displacement) -> npt.NDArray[np.float64] | None:
        """Centres of the markers, shape (markers, 3) [mm]; None where the design has none."""
        return self.markers.displaced(deformation.displacements_mm) if self.markers is not None else None

    @on_one_blas_thread
    def view(self, state: FrameState, deformation: Deformation | Displacement) -> View:
        """Meshes, object and light of a state as the renderer wants them; `RenderError` where a wall is too thin."""
        is_hidden = self.design.is_opaque  # behind a coat a touch alone is seen
        indenter = None if is_hidden and not state.can_touch else self.indenter(state)
        outside = View() if is_hidden else View(
            indenter=indenter, flashlight_x_mm=state.light_x_mm if state.flashlight else None,
            facing_mm=state.facing_mm, passing_mm=state.passing_mm,
            companion=Pose.from_key(state.companion) if state.companion is not None else None,
        )  # fmt: skip
        if deformation.is_rest or (indenter is None and not self.contact.keeps_dent):
            return replace(outside, indenter=indenter)
        body, infill = deformed_vertices(
            self.meshes, deformation.displacements_mm, indenter, self.contact, still_mm=self.settings.still_mm
        )
        if infill is not None and self.elastomer.infill is not None and self.elastomer.grid is not None:
            check_walls(infill, self.elastomer.boxed_cells, self.elastomer.grid)
        markers = None
        if self.meshes.markers is not None:
            markers = self.meshes.markers.displaced(deformation.displacements_mm)
        return replace(outside, body=body, infill=infill, markers=markers, is_released=not state.can_touch)

    @property
    def lit(self) -> tuple[bool, bool, bool]:
        """Whether any light of the untouched sensor shines in red, green and blue."""
        return self.rig.lit(is_opaque=self.design.is_opaque)

    def radiance(self, state: FrameState, deformation: Deformation | Displacement) -> FloatImage:
        """Linear radiance of a state, anchored to the untouched sensor, shape (rows, columns, 3)."""
        return self.render(state, deformation)[0]

    @on_one_blas_thread
    def render(self, state: FrameState, deformation: Deformation | Displacement) -> tuple[FloatImage, Origin]:
        """Radiance of a state, and the origin of its light.

        Raises:
            ConfigError: The fast tier is asked for, does not know the touch, and may not render it truly.
        """
        if self.settings.tier == "fast" and (found := self.emulation.frame(self, state, deformation)) is not None:
            return found
        view = self.view(state, deformation)
        return (self.renderer if view.facing_mm is None else self._facing_renderer()).render(view)

    def _facing_renderer(self) -> Renderer:
        """For views with another finger; built with the first of them."""
        if self._facing is None:
            self._facing = self.renderer.facing_another((self.opposite or self).renderer, self.companion)
        return self._facing


def sensor_exposure(sensor: Sensor, untouched: FloatImage) -> Array:
    """Gain of each channel, shape (3,), as metered on the whole image of the untouched sensor and locked."""
    camera = sensor.rig.camera
    whole = untouched if camera.region_px is None else sensor.renderer.metered()
    return meter(whole, camera, sensor.lit)


def sensor_camera(sensor: Sensor, untouched: FloatImage) -> CameraStream:
    """A sensor's camera, ready to film, as exposed on what it reads out at rest (`RenderError`: it never settles)."""
    rig, room = sensor.rig, room_radiance(sensor, untouched)
    whole = untouched if rig.camera.region_px is None else sensor.renderer.metered()
    return CameraStream.of(rig.camera, whole, sensor.lit, room=room)


def room_radiance(sensor: Sensor, untouched: FloatImage) -> FloatImage | None:
    """What the room's light makes of the untouched image, which swings with the mains; None where it is dark."""
    rig = sensor.rig
    if max(rig.room_light) == 0 or (rig.camera.flicker is None and rig.camera.led_drift is None):
        return None
    if not any(max(radiance) for radiance in rig.lamps):
        return untouched
    room = sensor.renderer.room_radiance()
    if room is not None:
        return np.minimum(room, untouched)
    dark = sensor.with_rig(rig.model_copy(update={"ambient": (0.0, 0.0, 0.0)}))
    return np.asarray(np.maximum(untouched - dark.renderer.radiance(View()), 0), np.float32)
