"""The few states in which the published figures are read, rendered for one choice of the optical constants.

What the LED strips light and what the room lights are rendered apart: light adds up, so that the strength of the room
against the strips needs no rendering of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.fit.constants import with_values
from magicsim.fit.model import Equilibria
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

FloatImage = npt.NDArray[np.float32]
GAPS_MM = (40.0, 20.0, 12.0, 6.0, 3.0, 1.0)
"""Where the approaching object is looked at."""
TOUCHES_MM = (0.3, 1.0)
"""Depths of a light and of a firm contact."""
OBJECT = "object={kind='sphere',radius_mm=36.0,color=[0.58,0.33,0.23]}"
"""A large object: a ball of an orange's size in the colour of a hand."""
QUALITY = ("render.samples=2", "render.particles=20000", "render.anchor_samples=8", "render.anchor_particles=150000")
DARK, BRIGHT = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
LAMPS, PRINT = "lamps", "print"
"""What `film_states` takes beside fields: `strips` or `leds`, `smooth` or `rough`."""
LEDS, LED_MM, LED_GAP_MM = 3, 1.0, 1.0
"""Single LEDs in place of a strip: how many, their radius and how far beside the block [mm]; assumed."""
ROUGHNESS = {"skin": 0.1, "walls": 0.1}
"""Of a rough print, within the range of docs/physics/print.md."""

_equilibria = Equilibria()


@dataclass(frozen=True, slots=True, kw_only=True)
class Approach:
    """Linear radiance of one sensor before an object that comes and touches, by some of its lights."""

    rest: FloatImage
    """Shape (rows, columns, 3)."""
    near: FloatImage
    """At `GAPS_MM`, shape (gaps, rows, columns, 3)."""
    touch: FloatImage
    """At `TOUCHES_MM`, shape (touches, rows, columns, 3)."""

    def plus(self, other: Self, share: float) -> Self:
        """Both lights at once, the other at a share of its strength."""
        return type(self)(
            rest=self.rest + np.float32(share) * other.rest,
            near=self.near + np.float32(share) * other.near,
            touch=self.touch + np.float32(share) * other.touch,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmedStates:
    """What all states look like by each light."""

    strips: Approach
    room: Approach
    """By a room of mean radiance 1."""
    light: FloatImage
    """What a flashlight of the rig's strength adds to the sensor at rest, shape (rows, columns, 3); never negative."""


def search_scene(columns: int, rows: int, quality: tuple[str, ...] = QUALITY) -> SceneConfig:
    """The default sensor with a large object in front, at some size of the image."""
    size = (f"rig.camera.columns={columns}", f"rig.camera.rows={rows}")
    return load_scene("near", [OBJECT, *size, *quality])


def film_states(scene: SceneConfig, values: Mapping[str, object]) -> FilmedStates:
    """All states of the sensor of a scene with some constants changed.

    Args:
        scene: From `search_scene`.
        values: By dotted field, as in `magicsim.fit.constants.with_values`; `rig.room` is the room, `LAMPS` and `PRINT`
            are choices.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    chosen = scene_fields(scene, values)
    room = chosen.pop("rig.room", scene.rig.room)
    strips = Sensor.for_scene(with_values(scene, chosen | {"rig.room": None, "rig.ambient": DARK}))
    lit = {"rig.strips.*.radiance": DARK, "rig.ambient": BRIGHT, "rig.room": room, "rig.leds": []}
    by_strips = _approach(strips)
    flash = strips.radiance(replace(UNTOUCHED, flashlight=True), strips.rest)
    return FilmedStates(
        strips=by_strips,
        room=_approach(Sensor.for_scene(with_values(scene, chosen | lit))),
        light=np.maximum(flash - by_strips.rest, 0).astype(np.float32),
    )


def scene_fields(scene: SceneConfig, values: Mapping[str, object]) -> dict[str, object]:
    """Fields of a scene for what `film_states` takes."""
    fields = dict(values)
    if fields.pop(PRINT, "smooth") == "rough":
        fields["design.roughness"] = ROUGHNESS
    if fields.pop(LAMPS, "strips") == "leds":
        fields |= {"rig.strips.*.radiance": DARK, "rig.leds": single_leds(scene)}
    return fields


def single_leds(scene: SceneConfig) -> list[dict[str, object]]:
    """LEDs in a row in place of each strip of a scene's rig, half way up the block, that shine into it."""
    half, height = np.array(scene.design.footprint_mm) / 2, scene.design.height_mm
    leds: list[dict[str, object]] = []
    for strip in scene.rig.strips:
        across, sign = "xy".index(strip.side[1]), -1 if strip.side[0] == "-" else 1
        axis = np.zeros(3)
        axis[across] = -sign
        for share in (np.arange(LEDS) + 0.5) / LEDS * 2 - 1:
            place = np.array([0.0, 0.0, height / 2])
            place[across], place[1 - across] = sign * (half[across] + LED_GAP_MM), share * half[1 - across]
            leds.append(
                {
                    "place_mm": place.tolist(), "direction": axis.tolist(), "radius_mm": LED_MM,
                    "radiance": list(strip.radiance),
                }
            )  # fmt: skip
    return leds


def _approach(sensor: Sensor) -> Approach:
    def at(gap_mm: float) -> FloatImage:
        state: FrameState = replace(UNTOUCHED, gap_mm=gap_mm)
        return sensor.radiance(state, sensor.rest if gap_mm > 0 else _equilibria.of(sensor, state))

    return Approach(
        rest=sensor.radiance(UNTOUCHED, sensor.rest),
        near=np.stack([at(gap) for gap in GAPS_MM]),
        touch=np.stack([at(-depth) for depth in TOUCHES_MM]),
    )
