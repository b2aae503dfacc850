"""What moves in the next frame, and the carriage that does: it speeds up, and slows down in time."""

import math
from dataclasses import dataclass
from typing import Literal

ROUNDING_MM = 1e-6
"""Distance from the target that counts as none [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Motion of the next frame."""

    fingers: Literal["close", "open", "stay"]
    carriage: Literal["to_b", "to_a", "stay"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """Where it is."""

    place_mm: float = 0.0
    speed_mm_s: float = 0.0
    acceleration_mm_s2: float = 0.0
    """In the last step."""


def driven(now: Carriage, target_mm: float, *, dt_s: float, most_mm_s: float, most_mm_s2: float) -> Carriage:
    """The carriage after a step towards a place: it speeds up, and slows down in time to stop there."""
    left, brake = target_mm - now.place_mm, most_mm_s2 * dt_s
    # A speed that falls by one brake in each of the next n steps stops exactly at the target.
    steps = math.floor((math.sqrt(1 + 8 * abs(left) / (brake * dt_s)) - 1) / 2)
    stopping = (abs(left) / dt_s + brake * steps * (steps + 1) / 2) / (steps + 1)
    wanted = math.copysign(min(most_mm_s, stopping), left)
    change = min(max(wanted - now.speed_mm_s, -brake), brake)
    speed = now.speed_mm_s + change
    place = now.place_mm + speed * dt_s
    return Carriage(
        place_mm=target_mm if abs(place - target_mm) < ROUNDING_MM else place,
        speed_mm_s=speed,
        acceleration_mm_s2=change / dt_s,
    )
