"""Which sensors are filmed: types, rooms, prints and objects drawn at random; each state of a take is rendered once.

The camera comes afterwards (`laboratory.rest_relative.cameras`). Every range is assumed, and none is taken from a
recording.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import ContactSettings, Keyframe, OutputSettings, SceneConfig, load_scene

SMALL = {"portrait": (120, 160), "landscape": (160, 120), "square": (128, 128)}
"""Columns and rows of the small images that the takes are made of."""
OBJECTS = (
    ("sphere:radius_mm=5,color=0.85x0.45x0.15", 1.6),
    ("box:size_mm=7x7x10,edge_radius_mm=0.5,color=0.75x0.75x0.7", 0.8),
    ("cylinder:radius_mm=3,length_mm=14,axis=y,edge_radius_mm=0.5,color=0.2x0.6x0.25", 1.0),
    ("punch:radius_mm=3,edge_radius_mm=0.5,color=0.6x0.15x0.1", 1.0),
    ("sphere:radius_mm=20,color=0.55x0.35x0.25", 0.8),
    ("sphere:radius_mm=3,color=0.2x0.2x0.25", 1.6),
    ("cylinder:radius_mm=5,length_mm=16,axis=x,edge_radius_mm=0.5,color=0.8x0.75x0.6", 0.9),
    ("domed_cylinder:radius_mm=4,color=0.35x0.35x0.35", 1.2),
    ("box:size_mm=10x5x8,edge_radius_mm=0.6,color=0.1x0.1x0.1", 0.8),
    ("sphere:radius_mm=6,color=0.2x0.3x0.7", 1.6),
)
"""What touches, and its deepest press [mm]."""
ROOMS = ("office", "window", "bench", "corridor")
GAPS_MM = (8.0, 3.0, 1.5, 0.6, 0.2)
DEPTHS_MM = (0.1, 0.2, 0.3, 0.45, 0.7, 1.0, 1.6)
"""Touches, as far as the object's deepest press goes. Takes but the first of a type leave out every second of both."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnTake:
    """One sensor, its room and an object."""

    name: str
    type: str
    scene: SceneConfig


def draw_takes(count: int) -> list[DrawnTake]:
    """So many takes of each type, types in turn, coated ones every third time; a longer list begins with a shorter."""
    names = [(name, number) for number in range(count) for name in TYPES if number % 3 == 0 or name not in COATED]
    return [_drawn(*each) for each in names]


def _log(random: np.random.Generator, low: float, high: float) -> float:
    return round(float(np.exp(random.uniform(np.log(low), np.log(high)))), 5)


def _even(random: np.random.Generator, low: float, high: float) -> float:
    return round(float(random.uniform(low, high)), 5)


def _room(random: np.random.Generator, low: float, high: float) -> list[str]:
    return [f"rig.room='{random.choice(ROOMS)}'", f"rig.ambient={[_log(random, low, high)] * 3}"]


def _printed(random: np.random.Generator, number: int) -> list[str]:
    """A grid's walls, infill and roughness, and a room, dark in every fourth take."""
    wall = _even(random, 0.08, 0.2)
    values = [f"design.wall_mm={wall}", f"design.cell_mm={round(0.9 - wall, 5)}",
              f"design.materials.infill.sigma_s_per_mm={_log(random, 0.15, 0.5)}"]  # fmt: skip
    if number % 2:
        values.append(f"design.roughness={{skin={_even(random, 0.1, 0.3)},walls={_even(random, 0.1, 0.3)}}}")
    return values + (["rig.room='dark'"] if number % 4 == 3 else _room(random, 0.03, 0.3))


def _mirror(random: np.random.Generator, led: tuple[float, float], ambient: tuple[float, float]) -> list[str]:
    """A half mirror, dots and white strips."""
    level = _log(random, *led)
    strips = ",".join(
        f"{{side='{side}',radiance={[round(level * float(random.uniform(0.75, 1.25)), 5)] * 3}}}"
        for side in ("-x", "+x", "-y", "+y")
    )
    return [
        f"rig.strips=[{strips}]", *_room(random, *ambient),
        f"design.markers.diameter_mm={_even(random, 0.8, 1.2)}", f"design.markers.pitch_mm={_even(random, 1.8, 2.4)}",
        f"design.coat.reflectance={_even(random, 0.2, 0.4)}", f"design.coat.transmittance={_even(random, 0.3, 0.55)}",
        f"design.core_mm={_even(random, 2.5, 4.0)}",
        f"design.materials.body.youngs_modulus_mpa={_log(random, 0.1, 0.4)}",
    ]  # fmt: skip


def _dots(random: np.random.Generator, room: tuple[float, float] | None) -> list[str]:
    values = [f"design.markers.diameter_mm={_even(random, 0.9, 1.4)}",
              f"design.markers.depth_mm={_even(random, 0.6, 1.2)}"]  # fmt: skip
    return values + (_room(random, *room) if room else [])


TYPES: Mapping[str, tuple[str, str]] = {
    "grid": ("demo", "portrait"),
    "mirror-dim": ("see-through-markers", "landscape"),
    "dots": ("marker-type", "square"),
    "mirror-bright": ("see-through-markers", "landscape"),
    "dome": ("mini-magictac-finger", "portrait"),
    "coat-dots": ("gelsight-type-markers", "landscape"),
    "coat-milky": ("translucent-9dtact", "landscape"),
}
"""Types of sensors: a scene that has design and rig, and the shape of the image."""
COATED = ("coat-dots", "coat-milky")
"""Types that see nothing outside."""


def _settings(name: str, random: np.random.Generator, number: int) -> list[str]:
    if name in ("grid", "dome"):
        return _printed(random, number)
    if name == "mirror-dim":
        return _mirror(random, (0.3, 1.0), (0.2, 0.6))
    if name == "mirror-bright":
        return _mirror(random, (2.0, 8.0), (0.02, 0.2))
    if name == "dots":
        return _dots(random, (0.05, 0.5))
    return ["render.samples=4", "render.anchor_samples=64"]


def _drawn(name: str, number: int) -> DrawnTake:
    kind = list(TYPES).index(name)
    random = np.random.default_rng([5501, kind, number])
    thing, deepest_mm = OBJECTS[(3 * number + 2 * kind) % len(OBJECTS)]
    preset, shape = TYPES[name]
    columns, rows = SMALL[shape]
    small = [f"rig.camera.columns={columns}", f"rig.camera.rows={rows}"]
    base = load_scene(preset, [*small, *_settings(name, random, number)], seed=5500 + 10 * number + kind)
    first, second = random.uniform(-3.5, 3.5, (2, 2)).round(3).tolist()
    return DrawnTake(
        name=f"{name}-{number:02d}",
        type=name,
        scene=base.model_copy(
            update={
                "references": 1, "frames_per_second": 30.0, "object": parse_object(thing),
                "contact": ContactSettings(friction=0.5), "output": OutputSettings.nothing(),
                "keyframes": tuple(_keyframes(first, second, deepest_mm, base.design.is_opaque, 2 if number else 1)),
            }
        ),
    )  # fmt: skip


def _keyframes(
    first: list[float], second: list[float], deepest_mm: float, is_opaque: bool, every: int
) -> list[Keyframe]:
    """Each state in one frame: untouched, nearer, deeper, sheared, at another place, a flashlight."""
    depths = [each for each in DEPTHS_MM[::every] if each <= deepest_mm]
    at: dict[str, Any] = {"x_mm": first[0], "y_mm": first[1]}
    other: dict[str, Any] = {"x_mm": second[0], "y_mm": second[1]}
    states: list[dict[str, Any]] = [
        {},
        *([] if is_opaque else [{"gap_mm": gap, **at} for gap in GAPS_MM[every - 1 :: every]]),
        *({"gap_mm": -depth, **at} for depth in depths),
        {"gap_mm": -0.45, "x_mm": first[0] + 0.4, "y_mm": first[1]},
        *([] if is_opaque else [{"gap_mm": 0.6, **other}]),
        {"gap_mm": -0.3, **other},
        {"gap_mm": -0.7, **other},
        *([] if is_opaque else [{"flashlight": True, "light_x_mm": x} for x in (-5.0, 4.0)]),
    ]
    return [Keyframe(frame=number, **state) for number, state in enumerate(states)]
