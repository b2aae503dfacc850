"""The window's sliders, buttons and keys: they say what is asked for, and follow what came of it."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from magicsim.live.sight import DESIGN_FIELDS, Wish
from magicsim.robot.workspace import Workspace

KEPT = 200
"""Steps that are remembered."""


class Course:
    """Normal and tangential force of the last steps."""

    def __init__(self) -> None:
        """Without any."""
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
        """Adds the controls to the panel."""
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
