"""Draws one see-through sensor with markers, its room, its camera and an object, as a scene that tells one story.

Every range is assumed: a type of sensor has units, benches and webcams, and nobody measured these. They lie around the
values of `geometry/see-through-markers.toml` and `scenes/rigs/see-through-sides.toml`, and camera effects within the
ranges that `magicsim.camera.effect_settings` gives.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import H264, Dust, Flicker, Glare, LedDrift, LiveExposure, Mjpeg, Shutter
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import ContactSettings, Keyframe, OutputSettings, SceneConfig, load_scene

Lights = Literal["dim", "bright"]
"""LEDs that leave the room to be seen, or that outshine it."""
Part = Literal["training", "test"]
ROOMS = ("office", "window", "bench")
STRIPS: Mapping[Lights, tuple[float, float]] = {"dim": (0.3, 1.0), "bright": (2.0, 8.0)}
"""Radiance of the LEDs, from and to."""
AMBIENT: Mapping[Lights, tuple[float, float]] = {"dim": (0.2, 0.6), "bright": (0.02, 0.2)}
"""Mean radiance of the room, in units of the LEDs'."""
OBJECTS: Mapping[Part, tuple[tuple[str, float, float], ...]] = {
    "training": (
        ("sphere:radius_mm=4,color=0.85x0.45x0.15", 0.9, 0.0),
        ("box:size_mm=7x7x10,edge_radius_mm=0.5,color=0.75x0.75x0.7", 0.5, 0.0),
        ("cylinder:radius_mm=3,length_mm=14,axis=y,edge_radius_mm=0.5,color=0.2x0.6x0.25", 0.7, 0.0),
        ("punch:radius_mm=3,edge_radius_mm=0.5,color=0.6x0.15x0.1", 0.6, 0.0),
        ("sphere:radius_mm=20,color=0.55x0.35x0.25", 0.5, 0.0),
        ("sphere:radius_mm=3,color=0.2x0.2x0.25", 1.0, 0.0),
    ),
    "test": (
        ("finger", 0.6, 10.8),
        ("sphere:radius_mm=6,color=0.2x0.3x0.7", 0.8, 0.0),
        ("cylinder:radius_mm=5,length_mm=16,axis=x,edge_radius_mm=0.5,color=0.8x0.75x0.6", 0.5, 0.0),
        ("domed_cylinder:radius_mm=4,color=0.35x0.35x0.35", 0.9, 0.0),
        ("sphere:radius_mm=30,color=0.8x0.4x0.05", 0.4, 0.0),
        ("box:size_mm=10x5x8,edge_radius_mm=0.6,color=0.1x0.1x0.1", 0.5, 0.0),
    ),
}
"""Objects of fit and test, none in both: what it is, deepest press [mm], and place along y [mm]."""
CLEAR_FRAMES, HELD_FRAMES, LIT_FRAMES = 20, 3, 4
NEAR_MM = (2.5, 1.2, 0.4)
LEAST_DEPTH_MM = 0.35
FLICKER_MS = 10.0
"""Period of the flicker of lamps on mains of 50 Hz [ms]."""
SEEDS: Mapping[Part, int] = {"training": 3501, "test": 3502}


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnSensor:
    """One recording to simulate."""

    name: str
    lights: Lights
    scene: SceneConfig

    @property
    def camera(self) -> Camera:
        """The scene's, set as drivers set it against the flicker of lamps: exposed for a multiple of its period."""
        drawn = self.scene.rig.camera
        exposure_ms = FLICKER_MS * max(1, round(drawn.shutter.exposure_ms / FLICKER_MS))
        return drawn.model_copy(update={"shutter": drawn.shutter.model_copy(update={"exposure_ms": exposure_ms})})


def draw_sensors(part: Part, count: int) -> list[DrawnSensor]:
    """So many sensors, dim and bright lights in turn; a longer list begins with a shorter one."""
    return [_sensor(part, number) for number in range(count)]


def _sensor(part: Part, number: int) -> DrawnSensor:
    random = np.random.default_rng([SEEDS[part], number])
    lights: Lights = "bright" if number % 2 else "dim"
    thing, press_mm, y_mm = OBJECTS[part][(number // 2 + number % 2 * 3) % len(OBJECTS[part])]
    place = random.uniform(-3.5, 3.5, 2) + np.array([0.0, y_mm])
    base = load_scene("see-through-markers", _overrides(random, lights), seed=SEEDS[part] + 10 * number)
    rig = base.rig.model_copy(update={"camera": _camera(base.rig.camera, random)})
    scene = base.model_copy(
        update={
            "rig": rig,
            "references": 30,
            "frames_per_second": 30.0,
            "object": parse_object(thing),
            "contact": ContactSettings(friction=0.5),
            "output": OutputSettings.nothing(),
            "keyframes": tuple(_story(place, press_mm, float(random.uniform(0.3, 0.7)))),
        }
    )
    return DrawnSensor(name=f"{part}-{number:02d}", lights=lights, scene=scene)


def _overrides(random: np.random.Generator, lights: Lights) -> list[str]:
    """Unit, LEDs and room."""

    def even(low: float, high: float) -> float:
        return round(float(random.uniform(low, high)), 5)

    def log(low: float, high: float) -> float:
        return round(float(np.exp(random.uniform(np.log(low), np.log(high)))), 5)

    led = log(*STRIPS[lights])
    uneven = [round(led * float(random.uniform(0.75, 1.25)), 5) for _ in range(4)]
    ambient = log(*AMBIENT[lights])
    values: dict[str, Any] = {
        "design.markers.diameter_mm": even(0.8, 1.2),
        "design.markers.pitch_mm": even(1.8, 2.2),
        "design.markers.margin_mm": even(0.3, 0.9),
        "design.coat.reflectance": even(0.2, 0.4),
        "design.coat.transmittance": even(0.3, 0.55),
        "design.core_mm": even(2.5, 3.5),
        "design.materials.body.youngs_modulus_mpa": log(0.1, 0.4),
        "design.materials.body.absorption_per_mm": log(0.001, 0.01),
        "rig.room": f"'{random.choice(ROOMS)}'",
        "rig.ambient": [ambient] * 3,
        "rig.camera.distance_mm": even(20, 28),
        "rig.camera.field_mm": even(25.5, 27.5),
    }
    strips = [
        f"{{side='{side}',radiance={[value] * 3}}}"
        for side, value in zip(("-x", "+x", "-y", "+y"), uneven, strict=True)
    ]
    return [f"rig.strips=[{','.join(strips)}]", *(f"{key}={value}" for key, value in values.items())]


def _camera(camera: Camera, random: np.random.Generator) -> Camera:
    """A webcam."""

    def log(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    mjpeg = Mjpeg(kind="mjpeg", quality=int(random.integers(75, 96)))
    h264 = H264(kind="h264", crf=int(random.integers(18, 27)))
    return camera.model_copy(
        update={
            "exposure_grey": float(random.uniform(40, 80)),
            "blur_px": float(random.uniform(0.7, 1.5)),
            "full_well_e": log(1e4, 6e4),
            "read_noise_e": log(4, 40),
            "vibration_px": log(0.003, 0.05),
            "pattern_seed": int(random.integers(1 << 30)),
            "live": LiveExposure() if random.random() < 0.5 else None,
            "led_drift": LedDrift(share=log(0.001, 0.01), time_s=log(5, 60)),
            "glare": Glare(share=float(random.uniform(0.01, 0.08)), radius_px=float(random.uniform(20, 60))),
            "dust": Dust(specks=int(random.integers(5, 30)), opacity=float(random.uniform(0.05, 0.4))),
            "flicker": Flicker(depth=float(random.uniform(0.02, 0.2))),
            "shutter": Shutter(exposure_ms=float(random.uniform(5, 30)), row_us=float(random.uniform(20, 80))),
            "compression": mjpeg if random.random() < 0.5 else h264,
        }
    )


def _story(place: np.ndarray, press_mm: float, shear_mm: float) -> Iterator[Keyframe]:
    """Untouched, nearer, pressed, sheared, gone, untouched again, a flashlight, untouched."""
    at: dict[str, Any] = {"x_mm": float(place[0]), "y_mm": float(place[1])}
    depths = (LEAST_DEPTH_MM, (LEAST_DEPTH_MM + press_mm) / 2, press_mm)
    sheared = at | {"x_mm": at["x_mm"] + shear_mm}
    states: list[tuple[int, dict[str, Any]]] = [
        (CLEAR_FRAMES, {}),
        *((HELD_FRAMES, {"gap_mm": gap, **at}) for gap in NEAR_MM),
        *((HELD_FRAMES, {"gap_mm": -depth, **at}) for depth in depths),
        (HELD_FRAMES, {"gap_mm": -press_mm, **sheared}),
        (HELD_FRAMES, {"gap_mm": NEAR_MM[1], **sheared}),
        (CLEAR_FRAMES, {}),
        *((LIT_FRAMES, {"flashlight": True, "light_x_mm": x}) for x in (-5.0, 4.0)),
        (LIT_FRAMES, {}),
    ]
    frame = 0
    for count, state in states:
        yield Keyframe(frame=frame, **state)
        yield Keyframe(frame=frame + count - 1, **state)
        frame += count
