"""One sensor in one scene: geometry, lattice and renderer, asked for deformations and images of single states."""

from copy import copy
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.camera.effects.video import check_codec
from magicsim.camera.exposure import Exposure, FloatImage, meter
from magicsim.camera.stream import CameraStream
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.indentation.timed import body_branches
from magicsim.deform.lattice.follow import follow_map
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.solve.problem import NewtonOptions
from magicsim.deform.solve.rigid_motion import is_there
from magicsim.geometry.elastomer import Elastomer, build_elastomer
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.light.records.untouched_states import UntouchedStates
from magicsim.light.renderer import Renderer
from magicsim.light.safe_gap import check_walls
from magicsim.light.world.finish import Finish
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.scenes.view import View
from magicsim.simulation.marker_truth import MarkerTracks
from magicsim.simulation.meshes import attach_meshes, deformed_vertices
from magicsim.simulation.plan import ScenePlan, as_seen, can_touch


class Sensor:
    """One sensor in one scene: solves and renders states on request, reusing what has not changed."""

    def __init__(
        self, scene: SceneConfig, *, untouched: UntouchedStates | None = None, newton: NewtonOptions | None = None
    ) -> None:
        """Builds geometry, lattice and renderer.

        Args:
            scene: What happens.
            untouched: Untouched states of sensors that other episodes share.
            newton: When a load step is good enough; the solver's own by default.

        Raises:
            ConfigError: The camera's codec is not installed.
            GeometryError: The design cannot be built.
            RenderError: The estimator cannot render these materials.
        """
        check_codec(scene.rig.camera.compression)
        self.scene = scene
        self._newton = newton
        self.elastomer: Elastomer = build_elastomer(scene.design)
        self.printed: Lattice = build_lattice(scene.design)
        """All planes of the design's lattice, which the displacements of an episode refer to."""
        self.lattice: Lattice = build_lattice(scene.design, zone=self._zone())
        """The lattice that is solved: as fine where the object can touch, coarser elsewhere."""
        self._printed_nodes = follow_map(self.lattice, self.printed.nodes_mm)
        self.markers = MarkerTracks.of(scene.design, self.lattice)
        self.meshes = attach_meshes(self.elastomer, self.lattice)
        self.renderer = build_renderer(scene, self.elastomer, untouched=untouched)
        self._solver: ContactSolver | None = None
        self.rest = Deformation.rest(self.lattice)

    def reseeded(self, turn: int) -> Self:
        """The same sensor in the same scene with other random numbers; geometry, lattice and Mitsuba scenes are shared.

        Args:
            turn: What is added to the scene's seed and to that of the untouched state.
        """
        render = self.scene.render.model_copy(update={"anchor_seed": self.scene.render.anchor_seed + turn})
        other = copy(self)
        other.scene = self.scene.model_copy(update={"seed": self.scene.seed + turn, "render": render})
        other.renderer = self.renderer.reseeded(seed=other.scene.seed, anchor_seed=render.anchor_seed)
        return other

    def _zone(self) -> Zone | None:
        states = [state for state in timeline(self.scene) if can_touch(state)]
        placed = [self.indenter(state) for state in states]
        return contact_zone([indenter for indenter in placed if indenter is not None], self.scene.design)

    def warm_up(self, plan: ScenePlan) -> None:
        """Compiles every kernel that a plan needs, so that the frames themselves are timed without it."""
        if any(frame.solve for frame in plan.frames):
            compile_kernels()
        states = [UNTOUCHED, *(frame.state for frame in plan.frames if frame.same_as is None)]
        kinds = {(state.has_object, state.flashlight): state for state in states}
        for state in kinds.values():
            self.renderer.warm_up(self.view(state, self.rest))

    def indenter(self, state: FrameState) -> Indenter | None:
        """The object as placed by a state."""
        if state.gap_mm is None or self.scene.object is None:
            return None
        return place_object(
            self.scene.object,
            gap_mm=state.gap_mm,
            x_mm=state.x_mm,
            y_mm=state.y_mm,
            twist_deg=state.twist_deg,
            design=self.scene.design,
        )

    def deform(self, state: FrameState, previous: Deformation) -> Deformation:
        """Equilibrium for a state in which contact is possible, warm-started from the previous one.

        The previous one itself where the object has not moved since, and nothing relaxes.

        Raises:
            ConvergenceError: No valid equilibrium was found.
        """
        indenter = self.indenter(state)
        if indenter is None:
            return self.rest
        if not self.scene.contact.rate_dependent and is_there(indenter, previous):
            return previous
        if self._solver is None:
            self._solver = ContactSolver(
                self.lattice,
                options=self._newton,
                friction=self.scene.contact.friction,
                point_spacing_mm=point_spacing_mm(indenter.shape),
                branches=body_branches(self.scene.design, self.lattice) if self.scene.contact.rate_dependent else None,
            )
        start = previous if not previous.is_rest else None
        return self._solver.solve(indenter, start, dt_s=1 / self.scene.frames_per_second)

    def printed_displacements_mm(self, deformation: Deformation) -> npt.NDArray[np.float32]:
        """Displacements of all nodes of the design's lattice, shape (printed nodes, 3) [mm]."""
        moved = self._printed_nodes.displaced(deformation.displacements_mm) - self.printed.nodes_mm
        return moved.astype(np.float32)

    def wanted_displacements_mm(self, deformation: Deformation) -> npt.NDArray[np.float32] | None:
        """The same where the scene's output asks for it."""
        return self.printed_displacements_mm(deformation) if self.scene.output.displacements else None

    def markers_mm(self, deformation: Deformation) -> npt.NDArray[np.float64] | None:
        """Centres of the markers, shape (markers, 3) [mm]; None where the design has none."""
        return self.markers.displaced_mm(deformation.displacements_mm) if self.markers is not None else None

    def view(self, state: FrameState, deformation: Deformation) -> View:
        """Meshes, object and light of a state as the renderer wants them.

        Raises:
            RenderError: A wall or the skin is too thin to be rendered.
        """
        state = as_seen(self.scene, state)
        indenter = self.indenter(state)
        light = state.light_x_mm if state.flashlight else None
        if deformation.is_rest or indenter is None:
            return View(indenter=indenter, flashlight_x_mm=light)
        body, infill = deformed_vertices(
            self.meshes, deformation, indenter, self.scene.contact, still_mm=self.scene.render.still_mm
        )
        if infill is not None and self.elastomer.infill is not None and self.elastomer.grid is not None:
            check_walls(infill, self.elastomer.printed_cells, self.elastomer.grid)
        shown = None if self.scene.design.is_opaque else indenter
        markers = None
        if self.meshes.markers is not None:
            markers = self.meshes.markers.displaced(deformation.displacements_mm)
        return View(body=body, infill=infill, markers=markers, indenter=shown, flashlight_x_mm=light)

    def radiance(self, state: FrameState, deformation: Deformation) -> FloatImage:
        """Linear radiance of a state, anchored to the untouched sensor, shape (rows, columns, 3)."""
        return self.renderer.radiance(self.view(state, deformation))


def build_renderer(scene: SceneConfig, elastomer: Elastomer, *, untouched: UntouchedStates | None = None) -> Renderer:
    """The renderer of a scene's elastomer, rig and object.

    Args:
        scene: What is rendered.
        elastomer: Its block.
        untouched: Where the sensor's untouched state is looked up and kept, for other episodes of it.

    Raises:
        RenderError: The estimator cannot render these materials.
    """
    surface, finish = None, None
    if scene.object is not None:
        surface = scene.object.surface()
        finish = Finish.of(scene.object, surface)
    return Renderer(
        elastomer,
        scene.rig,
        scene.render,
        seed=scene.seed,
        object_mesh=surface,
        object_finish=finish,
        untouched=untouched,
    )


def sensor_exposure(sensor: Sensor, untouched: FloatImage) -> Exposure:
    """Exposure of a sensor's camera, measured on the whole image of the untouched sensor and locked.

    Args:
        sensor: In its scene.
        untouched: What the camera reads out at rest, shape (rows, columns, 3).
    """
    return meter(_whole(sensor, untouched), sensor.scene.rig.camera, sensor.scene.rig.lit)


def sensor_camera(sensor: Sensor, untouched: FloatImage) -> CameraStream:
    """A sensor's camera, ready to film, as exposed on the untouched sensor.

    Args:
        sensor: In its scene.
        untouched: What the camera reads out at rest, shape (rows, columns, 3).

    Raises:
        RenderError: Exposure fails or never settles.
    """
    rig, room = sensor.scene.rig, room_radiance(sensor, untouched)
    return CameraStream.of(rig.camera, _whole(sensor, untouched), rig.lit, room=room)


def room_radiance(sensor: Sensor, untouched: FloatImage) -> FloatImage | None:
    """What the room's light makes of the untouched image, which swings with the mains while LEDs do not.

    Args:
        sensor: In its scene.
        untouched: What the camera reads out at rest, shape (rows, columns, 3).

    Returns:
        Shape (rows, columns, 3); None where the room is dark, or where nothing asks for it.
    """
    rig = sensor.scene.rig
    if max(rig.room_light) == 0 or (rig.camera.flicker is None and rig.camera.led_drift is None):
        return None
    if not any(max(radiance) for radiance in rig.lamps):
        return untouched
    dark = sensor.scene.model_copy(update={"rig": rig.model_copy(update={"ambient": (0.0, 0.0, 0.0)})})
    return np.asarray(np.maximum(untouched - build_renderer(dark, sensor.elastomer).radiance(View()), 0), np.float32)


def _whole(sensor: Sensor, untouched: FloatImage) -> FloatImage:
    """The whole untouched image, which exposure is measured on."""
    return untouched if sensor.scene.rig.camera.region_px is None else sensor.renderer.metered()
