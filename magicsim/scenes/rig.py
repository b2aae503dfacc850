"""What surrounds the elastomer: LED strips, lens, flashlight and camera. The configuration of `scenes/rigs/*.toml`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field

from magicsim.camera.camera import Camera, Lens
from magicsim.config.models import Config, load_preset, validate
from magicsim.scenes.room import Passing, room_passing, room_radiance

FARTHEST_MM = 2000.0
"""Half of a room's width [mm]: what is further away matters to no frame."""
PlaceMm = Annotated[float, Field(ge=-FARTHEST_MM, le=FARTHEST_MM)]
FAINTEST, BRIGHTEST = 1e-6, 1000.0
"""Radiances that light particles still carry without losing digits, beside 0."""


def _not_faint(radiance: float) -> float:
    if 0 < radiance < FAINTEST:
        raise ValueError(f"{radiance:g} is not allowed: must be 0 (off) or a number of at least {FAINTEST:g}")
    return radiance


Radiance = Annotated[float, Field(ge=0, le=BRIGHTEST), AfterValidator(_not_faint)]
"""In units that only compare lights with each other: exposure makes up for all of them. 0 is a light that is off."""
Rgb = tuple[Radiance, Radiance, Radiance]
Vector = tuple[PlaceMm, PlaceMm, PlaceMm]
Lobe = Annotated[float, Field(ge=1, le=200)]
"""Exponent of the cosine that the intensity falls with; 1 is a matte emitter, a bare die, or one under a diffuser."""


class Led(Config):
    """One LED: a small disk in the air around the block."""

    place_mm: Vector
    """Centre of the disk; the contact face is at z = 0, block and plate above it [mm]."""
    direction: Vector
    """Where it shines; any length but 0."""
    radiance: Rgb
    """Along its axis, relative units."""
    radius_mm: Annotated[float, Field(ge=0.05, le=20)] = 0.5
    """Radius of the disk [mm]."""
    lobe: Lobe = 1.0
    """Exponent m: intensity falls as cos^m of the angle from the axis; half of it is left at 60 degrees with 1, at 33
    with 4, at 21 with 10."""

    def _problems(self) -> Iterator[str | None]:
        if not any(self.direction):
            yield f"direction = {list(self.direction)} is not allowed: must not be 0"

    @property
    def axis(self) -> tuple[float, float, float]:
        """Unit vector along which it shines."""
        x, y, z = (np.array(self.direction) / np.linalg.norm(self.direction)).tolist()
        return x, y, z

    def problem(self, number: int, footprint_mm: tuple[float, float], top_mm: float) -> str | None:
        """Why a block with a lens plate cannot have this LED beside it, with its number, or None where it can."""
        reach = self.radius_mm * np.sqrt(np.maximum(1 - np.square(self.axis), 0))
        low, high = np.array(self.place_mm) - reach, np.array(self.place_mm) + reach
        half = np.array(footprint_mm) / 2
        if (high[:2] > -half).all() and (low[:2] < half).all() and high[2] > 0 and low[2] < top_mm:
            return (
                f"rig.leds.{number}.place_mm = {list(self.place_mm)} is not allowed: must be outside of the block and "
                f"its plate, {footprint_mm[0]:g} x {footprint_mm[1]:g} mm and z from 0 to {top_mm:g}"
            )
        return None


class LedRing(Config):
    """A ring around the camera's view that shines through the window: even under a diffuser, or single LEDs."""

    radiance: Rgb
    """Towards the block, relative units."""
    radius_mm: Annotated[float, Field(ge=0.5, le=500)]
    """Mean radius [mm]."""
    width_mm: Annotated[float, Field(ge=0.1, le=100)] = 2.0
    """Width of the even ring, or diameter of each LED [mm]."""
    gap_mm: Annotated[float, Field(ge=0.05, le=500)] = 1.0
    """Distance behind the lens plate [mm]."""
    leds: Annotated[int, Field(ge=0, le=200)] = 0
    """Number of LEDs; 0 is an even ring, LEDs under a diffuser."""
    lobe: Lobe = 1.0
    """Exponent of the cosine that the intensity falls with, see `Led.lobe`."""

    def _problems(self) -> Iterator[str | None]:
        if self.width_mm / 2 >= self.radius_mm:
            yield f"width_mm = {self.width_mm:g} is not allowed: must be below twice radius_mm = {self.radius_mm:g}"


NEAREST_MM, FARTHEST_ROOM_MM = 5.0, 1e6
"""Distances of a room that is not infinitely far away [mm]."""
DARK = "dark"
"""The room without light."""
DIM = (0.1, 0.1, 0.1)
"""Radiance of a room whose light nobody gives, relative to the strips': assumed."""
Side = Literal["-x", "+x", "-y", "+y"]
INSET_MM = 0.2
"""How far inside the body the emitting face of an LED strip in optical contact lies [mm]."""


class LedStrip(Config):
    """A strip of LEDs along one side face, shining into the block."""

    side: Side
    """Side face that it lies along."""
    radiance: Rgb
    """Emitted radiance per channel, relative units."""
    coupling: Literal["contact", "air"] = "contact"
    """Optical contact (emitter just inside the body) or behind an air gap."""
    margin_mm: Annotated[float, Field(ge=0.1, le=5)] = 0.4
    """Distance of the strip's ends from the edges of the side face [mm]."""
    reflectance: Annotated[float, Field(ge=0, le=1)] = 0.3
    """Diffuse reflectance of the strip itself."""


class Flashlight(Config):
    """Outside light: a disk that faces the contact face from below."""

    radiance: Rgb = (1.0, 1.0, 1.0)
    """Emitted radiance per channel, relative units."""
    radius_mm: Annotated[float, Field(ge=0.1, le=500)] = 8.0
    """Radius of the disk [mm]."""
    distance_mm: Annotated[float, Field(ge=0.1, le=10_000)] = 40.0
    """Distance from the undeformed contact face [mm]."""
    x_mm: PlaceMm = 0.0
    """Centre along x [mm]."""
    y_mm: PlaceMm = 0.0
    """Centre along y [mm]."""


MOST_LIGHTS = 32


class Rig(Config):
    """Everything optical around one elastomer."""

    schema_version: Literal[1]
    strips: Annotated[tuple[LedStrip, ...], Field(max_length=32)]
    """None is a dark sensor; 32 lights have random numbers of their own."""
    leds: Annotated[tuple[Led, ...], Field(max_length=32)] = ()
    """Single LEDs in the air around the block; none by default."""
    ring: LedRing | None = None
    """Ring of light behind the lens plate; none by default."""
    lens: Lens = Lens()
    flashlight: Flashlight = Flashlight()
    ambient: Rgb = (0.0, 0.0, 0.0)
    """Radiance of the room below the contact face, relative units: the same all around, or the mean of `room`."""
    room: str | None = None
    """Where that light comes from: `office`, `window`, `bench`, `corridor`, or an equirectangular image (PNG or JPEG,
    sRGB), whose middle is what the sensor looks at; none is even light, and `dark` turns the room off, whatever
    `ambient` is."""
    room_distance_mm: Annotated[float, Field(ge=NEAREST_MM, le=FARTHEST_ROOM_MM)] | None = None
    """Radius of a sphere around the middle of the contact face that the room's picture stands on, shining alike in all
    directions [mm]; infinitely far away by default."""
    passing: Passing | None = None
    """What passes behind whatever approaches; that of the room by default, which has none but in `corridor`."""
    camera: Camera = Camera()

    @property
    def lamps(self) -> tuple[tuple[float, float, float], ...]:
        """Radiances of the sensor's own lights: strips, single LEDs, ring."""
        ring = (self.ring.radiance,) if self.ring is not None else ()
        return (*(strip.radiance for strip in self.strips), *(led.radiance for led in self.leds), *ring)

    def _problems(self) -> Iterator[str | None]:
        if len(self.lamps) > MOST_LIGHTS:
            yield f"{len(self.lamps)} strips, leds and ring are not allowed: must be at most {MOST_LIGHTS} together"
        if self.ring is not None and self.ring.gap_mm >= self.camera.distance_mm:
            yield (
                f"ring.gap_mm = {self.ring.gap_mm:g} is not allowed: must be below camera.distance_mm = "
                f"{self.camera.distance_mm:g}, so that the ring is in front of the pinhole"
            )
        if self.room is not None and self.room != DARK:
            room_radiance(self.room)
            if not any(self.ambient):
                yield f"room = '{self.room}' is not allowed with ambient = 0: give the radiance of the room"
        if self.passing is not None and not any(self.room_light):
            yield "passing is not allowed in a dark room: give the radiance of the room as ambient"
        if self.room_distance_mm is not None and self.moving is not None:
            yield (
                f"room_distance_mm = {self.room_distance_mm:g} is not allowed where something passes in the room: must "
                "be left out, or the room be a still one, such as 'office'"
            )

    @property
    def moving(self) -> Passing | None:
        """What passes in the room, None where nothing does."""
        if self.passing is not None or self.room in (None, DARK):
            return self.passing
        return room_passing(self.room)

    @property
    def room_light(self) -> Rgb:
        """Mean radiance of the room, 0 in a dark one."""
        return (0.0, 0.0, 0.0) if self.room == DARK else self.ambient

    @property
    def near_mm(self) -> float | None:
        """Distance of the room's picture [mm], None where it is infinitely far away, or the room dark."""
        return self.room_distance_mm if any(self.room_light) else None

    def lit(self, *, is_opaque: bool) -> tuple[bool, bool, bool]:
        """Whether any light of the untouched sensor shines in red, green and blue: no room's through an opaque coat."""
        room = (0.0, 0.0, 0.0) if is_opaque else self.room_light
        red, green, blue = (any(each) for each in zip(room, *self.lamps, strict=True))
        return red, green, blue


def load_rig(name: str | Path, overrides: Sequence[str] = ()) -> Rig:
    """Reads a rig, such as `digit-office`: what surrounds a block, with `dotted.key=value` settings.

    Raises:
        PresetError: The rig does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(Rig, "rig", name, overrides)


def in_room(rig: Rig, room: str) -> Rig:
    """The rig in a room, a name, image or `dark`; its own light is scaled by nothing."""
    values = rig.model_dump() | {"room": room}
    if room != DARK and not any(rig.ambient):
        values["ambient"] = DIM
    return validate(Rig, values, source="room")
