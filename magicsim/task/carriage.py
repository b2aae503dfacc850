"""The carriage between A and B: bounded speed and acceleration, along the gripper's x."""

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """Where it is."""

    place_mm: float = 0.0
    """From A [mm]."""
    speed_mm_s: float = 0.0
    acceleration_mm_s2: float = 0.0
    """In the last step."""


def driven(now: Carriage, target_mm: float, *, dt_s: float, most_mm_s: float, most_mm_s2: float) -> Carriage:
    """The carriage after a step towards a place: it speeds up, and slows down in time to stop there.

    Args:
        now: Where it is.
        target_mm: Where to [mm].
        dt_s: Time [s].
        most_mm_s: Largest speed [mm/s].
        most_mm_s2: Largest acceleration [mm/s2].
    """
    left = target_mm - now.place_mm
    # As fast as still stops there, counting the way of this step.
    brake = most_mm_s2 * dt_s
    stopping = math.sqrt(brake**2 / 4 + 2 * most_mm_s2 * abs(left)) - brake / 2
    wanted = math.copysign(min(most_mm_s, stopping), left)
    change = min(max(wanted - now.speed_mm_s, -brake), brake)
    speed = now.speed_mm_s + change
    place = now.place_mm + speed * dt_s
    if abs(left) <= abs(speed) * dt_s + 1e-9 and abs(speed) <= brake + 1e-9:  # arrived
        return Carriage(place_mm=target_mm, speed_mm_s=0.0, acceleration_mm_s2=-now.speed_mm_s / dt_s)
    return replace(now, place_mm=place, speed_mm_s=speed, acceleration_mm_s2=change / dt_s)
