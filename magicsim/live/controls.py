"""The window's sliders, buttons and keys: they say what is asked for, and follow what came of it."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import viser
from viser.transforms import SO3

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.live.sight import DESIGN_FIELDS, Sight, Wish
from magicsim.robot.workspace import Workspace

STILL, MOVED = np.array([120.0, 132.0, 150.0]), np.array([205.0, 60.0, 20.0])
"""Colour of a node at rest and of one that has moved by `FULL_MM`, RGB 0..255."""
FULL_MM = 0.5
"""Displacement of the strongest colour [mm]."""


def lattice_edges(lattice: Lattice) -> Index:
    """Pairs of neighbouring nodes, each once, shape (edges, 2).

    Nodes are numbered x fastest and z slowest. Edges along the sensor's axis are left out inside the block, where they
    would hide the layers.
    """
    counts = tuple(len(planes) for planes in lattice.planes_mm)
    number = np.arange(len(lattice.nodes_mm)).reshape(counts[::-1])
    along_x = np.stack([number[:, :, :-1], number[:, :, 1:]], -1).reshape(-1, 2)
    along_y = np.stack([number[:, :-1], number[:, 1:]], -1).reshape(-1, 2)
    rim = np.zeros(number.shape[1:], bool)
    rim[[0, -1], :] = rim[:, [0, -1]] = True
    along_z = np.stack([number[:-1, rim], number[1:, rim]], -1).reshape(-1, 2)
    return np.concatenate([along_x, along_y, along_z])


def segment_colors(displacement_mm: Array, edges: Index) -> npt.NDArray[np.uint8]:
    """Colour of both ends of each edge, from how far its nodes have moved, uint8 of shape (edges, 2, 3)."""
    share = np.clip(displacement_mm / FULL_MM, 0, 1)[edges][..., None]
    return np.asarray(STILL + share * (MOVED - STILL), np.uint8)


Dragged = Callable[[float, float, float], None]
"""Takes x, y and the height of the object's origin above its place at a gap of 0 [mm]."""
LINE_MM, HANDLE_MM = 0.08, 6.0
GREY_TONE = 1 / 2.2


class View3D:
    """What viser's scene shows; handles of an earlier block are replaced."""

    def __init__(self, server: viser.ViserServer, space: Workspace, dragged: Dragged) -> None:
        """An empty scene, looked at from below the contact face."""
        self._server, self._dragged = server, dragged
        server.scene.set_up_direction("+z")
        server.initial_camera.position = (21.0, -33.0, -18.0)
        server.initial_camera.look_at = (0.0, 0.0, 0.5)
        self._edges: npt.NDArray[np.int64] | None = None
        self._lines: viser.LineSegmentsHandle | None = None
        self._mesh: viser.MeshHandle | None = None
        self._is_held = False
        low, high = space.gap_mm
        self._handle = server.scene.add_transform_controls(
            "/handle",
            scale=HANDLE_MM,
            disable_rotations=True,
            translation_limits=(space.x_mm, space.y_mm, (-high - HANDLE_MM, -low + HANDLE_MM)),
            depth_test=False,
            visible=False,
        )
        self._handle.on_update(lambda event: self._moved(event.client_id, str(event.phase)))

    def show_block(self, lattice: Lattice, thing: SurfaceMesh | None, color: tuple[float, float, float]) -> None:
        """Puts another block and object in place."""
        self._edges = lattice_edges(lattice)
        points = lattice.nodes_mm[self._edges].astype(np.float32)
        colors = segment_colors(np.zeros(len(lattice.nodes_mm)), self._edges)
        self._lines = self._server.scene.add_line_segments("/lattice", points, colors, thickness=LINE_MM)
        if thing is not None:
            tone = tuple(round(255 * value**GREY_TONE) for value in color)
            self._mesh = self._server.scene.add_mesh_simple(
                "/object", thing.vertices.astype(np.float32), thing.faces.astype(np.uint32), color=tone, opacity=0.55
            )

    def show(self, sight: Sight) -> None:
        """Moves everything to where a sight has it, and the handle to the object's gap."""
        if self._lines is not None and self._edges is not None:
            with self._server.atomic():
                self._lines.points = sight.nodes_mm[self._edges].astype(np.float32)
                self._lines.colors = segment_colors(sight.displacement_mm, self._edges)
        pose = sight.object_pose
        self._handle.visible = pose is not None
        if self._mesh is None:
            return
        self._mesh.visible = pose is not None
        if pose is None:
            return
        self._mesh.position, self._mesh.wxyz = pose.position_mm, SO3.from_matrix(pose.rotation).wxyz
        if not self._is_held:
            self._handle.position = (float(pose.position_mm[0]), float(pose.position_mm[1]), -sight.wish.gap_mm)

    def _moved(self, client: int | None, phase: str) -> None:
        if client is None:  # the window itself has moved it
            return
        self._is_held = phase != "end"
        x, y, z = (float(value) for value in self._handle.position)
        self._dragged(x, y, z)


KEPT = 200
"""Steps that are remembered."""


class Course:
    """Normal and tangential force of the last steps."""

    def __init__(self) -> None:
        self._steps: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._first = 0

    def add(self, force_n: tuple[float, float, float]) -> None:
        """Takes the force of the object on the sensor [N]."""
        self._first += len(self._steps) == KEPT
        x, y, z = force_n
        self._steps.append((z, float(np.hypot(x, y))))

    def columns(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Number of each step, its normal force and its tangential force [N], each of shape (steps,); two at least."""
        steps = list(self._steps) or [(0.0, 0.0)]
        steps = steps if len(steps) > 1 else [steps[0], steps[0]]
        normal, tangential = np.array(steps).T
        return np.arange(self._first, self._first + len(steps), dtype=float), normal, tangential


STEP_MM, STEP_DEG = 0.1, 5.0
"""How far a key moves the object."""
KEYS = (
    ("Object to -x", "arrowleft", {"x_mm": -STEP_MM}),
    ("Object to +x", "arrowright", {"x_mm": STEP_MM}),
    ("Object to -y", "arrowdown", {"y_mm": -STEP_MM}),
    ("Object to +y", "arrowup", {"y_mm": STEP_MM}),
    ("Press", "P", {"gap_mm": -STEP_MM}),
    ("Lift", "L", {"gap_mm": STEP_MM}),
    ("Turn left", "J", {"twist_deg": STEP_DEG}),
    ("Turn right", "K", {"twist_deg": -STEP_DEG}),
)
"""Label, key and motion; with the shift key, so that viser's own keys stay."""
PLACE = {
    "gap_mm": ("gap [mm]", 0.05, "Distance from the untouched face; below 0 the object presses."),
    "x_mm": ("x [mm]", 0.05, "Along the short side."),
    "y_mm": ("y [mm]", 0.05, "Along the long side."),
    "twist_deg": ("twist [deg]", 1.0, "About the sensor's axis."),
}
LEDS = ("LED red", "LED green", "LED blue")
MOST_LED, MOST_LIGHT_MM = 2.0, 12.0


class Controls:
    """Everything in the panel that asks for something."""

    def __init__(self, server: viser.ViserServer, space: Workspace, wish: Wish, asked: Callable[[Wish], None]) -> None:
        self._gui, self._space, self._asked, self._wish = server.gui, space, asked, wish
        self._built = wish.design
        self._followed: list[tuple[Any, str, int | None]] = []
        """Each control, the field of the wish that it shows, and the number of its value there where it has several."""
        with self._gui.add_folder("Object"):
            for name, (label, step, hint) in PLACE.items():
                low, high = getattr(space, name)
                self._slider(name, label, low, high, step, hint)
            self._bind(self._gui.add_checkbox("in front of the sensor", wish.has_object), "has_object")
        with self._gui.add_folder("Light and exposure", expand_by_default=False):
            for number, label in enumerate(LEDS):
                slider = self._gui.add_slider(label, 0.0, MOST_LED, 0.05, wish.led_strength[number])
                self._bind(slider, "led_strength", number)
            self._slider("exposure_grey", "exposure [grey]", 20.0, 200.0, 1.0, "Mean grey level.")
            self._bind(self._gui.add_checkbox("flashlight", wish.flashlight), "flashlight")
            self._slider("light_x_mm", "flashlight x [mm]", -MOST_LIGHT_MM, MOST_LIGHT_MM, 0.5, "Its place.")
        with self._gui.add_folder("Design", expand_by_default=False):
            self._design = [
                self._gui.add_slider(f"{name[:-3]} [mm]", min(low, value), max(high, value), 0.05, value)
                for (name, (low, high)), value in zip(DESIGN_FIELDS.items(), wish.design, strict=True)
            ]
            self._followed += [(slider, "design", number) for number, slider in enumerate(self._design)]
            build = self._gui.add_button("Build this design", hint="Builds the block anew and renders it untouched.")
            build.on_click(lambda _: self._ask_for_design())
        for label, key, motion in KEYS:
            command = self._gui.add_command(label, hotkey=key, modifier="shift")  # type: ignore[arg-type]
            command.on_trigger(self._pusher(motion))

    @property
    def wish(self) -> Wish:
        """What is asked for now."""
        return self._wish

    def drag(self, x_mm: float, y_mm: float, height_mm: float) -> None:
        """Asks for a place of the handle in 3D."""
        wish = replace(self._wish, has_object=True)
        by = {"x_mm": x_mm - wish.x_mm, "y_mm": y_mm - wish.y_mm, "gap_mm": -height_mm - wish.gap_mm}
        self.ask(wish.pushed(self._space, **by))

    def follow(self, wish: Wish, *, is_last: bool) -> None:
        """Shows what was done; while newer wishes wait, only what was refused would be news.

        A design that is being chosen stays until it is built or refused.
        """
        if not is_last:
            return
        is_chosen = wish.design == self._wish.design == self._built
        self._wish, self._built = wish, wish.design
        for handle, name, number in self._followed:
            if name == "design" and is_chosen:
                continue
            field = getattr(wish, name)
            value = field if number is None else field[number]
            if handle.value != value:
                handle.value = value

    def _ask_for_design(self) -> None:
        self.ask(replace(self._wish, design=tuple(float(slider.value) for slider in self._design)))

    def _pusher(self, motion: dict[str, float]) -> Callable[[object], None]:
        return lambda _: self.ask(self._wish.pushed(self._space, **motion))

    def _slider(self, name: str, label: str, low: float, high: float, step: float, hint: str) -> None:
        value = getattr(self._wish, name)
        self._bind(self._gui.add_slider(label, min(low, value), max(high, value), step, value, hint=hint), name)

    def _bind(self, handle: Any, name: str, number: int | None = None) -> None:  # noqa: ANN401 -- viser's handle
        """Lets a control ask for its field of the wish, and follow it."""

        def changed(event: Any) -> None:  # noqa: ANN401 -- viser's event
            if event.client_id is None:  # the window itself has set it
                return
            value: Any = handle.value if isinstance(handle.value, bool) else float(handle.value)
            if number is not None:
                before = getattr(self._wish, name)
                value = (*before[:number], value, *before[number + 1 :])
            self.ask(replace(self._wish, **{name: value}))

        handle.on_update(changed)
        self._followed.append((handle, name, number))

    def ask(self, wish: Wish) -> None:
        """Asks for a wish, as a control does."""
        self._wish = wish
        self._asked(wish)
