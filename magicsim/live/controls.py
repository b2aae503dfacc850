"""The window's sliders, buttons and keys: they say what is asked for, and follow what came of it."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.live.sight import DESIGN_FIELDS, Scenery, Wish
from magicsim.robot.workspace import Workspace

Colors = npt.NDArray[np.uint8]
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


def segment_colors(displacement_mm: Array, edges: Index) -> Colors:
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

    def show(self, shape: Scenery, gap_mm: float) -> None:
        """Moves everything to a sight's shape, and the handle to the object's gap [mm]."""
        if self._lines is not None and self._edges is not None:
            with self._server.atomic():
                self._lines.points = shape.nodes_mm[self._edges].astype(np.float32)
                self._lines.colors = segment_colors(shape.displacement_mm, self._edges)
        is_there = shape.object_position_mm is not None and shape.object_rotation is not None
        self._handle.visible = is_there
        if self._mesh is None:
            return
        self._mesh.visible = is_there
        if shape.object_position_mm is None or shape.object_rotation is None:
            return
        self._mesh.position = shape.object_position_mm
        self._mesh.wxyz = quaternion(shape.object_rotation)
        if not self._is_held:
            x, y, _ = shape.object_position_mm
            self._handle.position = (float(x), float(y), -gap_mm)

    def _moved(self, client: int | None, phase: str) -> None:
        if client is None:  # the window itself has moved it
            return
        self._is_held = phase != "end"
        x, y, z = (float(value) for value in self._handle.position)
        self._dragged(x, y, z)


def quaternion(rotation: npt.NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a rotation matrix of shape (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(w), float(x), float(y), float(z)


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


Asked = Callable[[Wish], None]
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

    def __init__(self, server: viser.ViserServer, space: Workspace, wish: Wish, asked: Asked) -> None:
        self._gui, self._space, self._asked, self._wish = server.gui, space, asked, wish
        self._sliders: dict[str, Any] = {}
        with self._gui.add_folder("Object"):
            for name, (label, step, hint) in PLACE.items():
                low, high = getattr(space, name)
                self._slider(name, label, low, high, step, getattr(wish, name), hint)
            self._there = self._gui.add_checkbox("in front of the sensor", wish.has_object)
            self._there.on_update(lambda event: self._change(event, has_object=bool(self._there.value)))
        with self._gui.add_folder("Light and exposure", expand_by_default=False):
            for number, label in enumerate(LEDS):
                self._led(number, label)
            self._slider("exposure_grey", "exposure [grey]", 20.0, 200.0, 1.0, wish.exposure_grey, "Mean grey level.")
            self._lamp = self._gui.add_checkbox("flashlight", wish.flashlight)
            self._lamp.on_update(lambda event: self._change(event, flashlight=bool(self._lamp.value)))
            self._slider("light_x_mm", "flashlight x [mm]", -MOST_LIGHT_MM, MOST_LIGHT_MM, 0.5, 0.0, "Its place.")
        with self._gui.add_folder("Design", expand_by_default=False):
            self._design = [
                self._gui.add_slider(f"{name[:-3]} [mm]", min(low, value), max(high, value), 0.05, value)
                for (name, (low, high)), value in zip(DESIGN_FIELDS.items(), wish.design, strict=True)
            ]
            build = self._gui.add_button("Build this design", hint="Builds the block anew and renders it untouched.")
            build.on_click(lambda _: self.ask(replace(self._wish, design=self._designed())))
        for label, key, motion in KEYS:
            command = self._gui.add_command(label, hotkey=key, modifier="shift")  # type: ignore[arg-type]
            command.on_trigger(self._pusher(motion))

    @property
    def wish(self) -> Wish:
        """What is asked for now."""
        return self._wish

    def drag(self, x_mm: float, y_mm: float, height_mm: float) -> None:
        """Asks for a place of the handle in 3D."""
        place = {"x_mm": x_mm, "y_mm": y_mm, "gap_mm": -height_mm}
        self.ask(replace(self._wish, has_object=True).pushed(self._space, **_ways(self._wish, place)))

    def follow(self, wish: Wish, *, is_last: bool) -> None:
        """Shows what was done; while newer wishes wait, only what was refused would be news."""
        if not is_last:
            return
        self._wish = wish
        for name, slider in self._sliders.items():
            _put(slider, getattr(wish, name))
        for number, slider in enumerate(self._leds):
            _put(slider, wish.led_strength[number])
        for slider, value in zip(self._design, wish.design, strict=True):
            _put(slider, value)
        _put(self._there, wish.has_object)
        _put(self._lamp, wish.flashlight)

    def _pusher(self, motion: dict[str, float]) -> Callable[[object], None]:
        return lambda _: self.ask(self._wish.pushed(self._space, **motion))

    def _slider(self, name: str, label: str, low: float, high: float, step: float, value: float, hint: str) -> None:
        slider = self._gui.add_slider(label, low, high, step, min(max(value, low), high), hint=hint)
        slider.on_update(lambda event: self._change(event, **{name: float(slider.value)}))
        self._sliders[name] = slider

    def _led(self, number: int, label: str) -> None:
        slider = self._gui.add_slider(label, 0.0, MOST_LED, 0.05, self._wish.led_strength[number])

        def changed(event: Any) -> None:  # noqa: ANN401 -- viser's event
            strength = list(self._wish.led_strength)
            strength[number] = float(slider.value)
            self._change(event, led_strength=tuple(strength))

        slider.on_update(changed)
        self._leds = [*getattr(self, "_leds", []), slider]

    def _designed(self) -> tuple[float, ...]:
        return tuple(float(slider.value) for slider in self._design)

    def _change(self, event: Any, **values: Any) -> None:  # noqa: ANN401
        if event.client_id is not None:  # None where the window itself has set it
            self.ask(replace(self._wish, **values))

    def ask(self, wish: Wish) -> None:
        """Asks for a wish, as a control does."""
        self._wish = wish
        self._asked(wish)


def _ways(wish: Wish, place: dict[str, float]) -> dict[str, float]:
    return {name: value - getattr(wish, name) for name, value in place.items()}


def _put(handle: Any, value: Any) -> None:  # noqa: ANN401
    if handle.value != value:
        handle.value = value
