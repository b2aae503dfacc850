"""Fingers on parallelograms: both turn about their motors in opposite directions and stay parallel.

At the angle t of the cranks from the direction of the fingers, positive when they lean away from each other:

    distance of the faces  = 2 (pivot + link sin t - pad)
    way along the fingers  = link cos t

Both are the same for both fingers, so their tips move on arcs and stay level. The published gripper names the motion
(Fan, Li, Zhang, arXiv 2505.24382); every number below is assumed.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

from scipy.optimize import brentq

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError

CREEP_MM = 0.4
"""Longest way of the faces towards each other between two equilibria once they touch [mm]."""
TOLERANCE = 0.01
"""Difference from the motors' force at which they stand, in units of it."""
FINEST_MM = 1e-5
"""Interval of distances at which the search for it ends in any case [mm]."""


def close_until(
    force_n: Callable[[float], float], keep: Callable[[], None], start: tuple[float, float], target_mm: float,
    limit_n: float,
) -> bool:  # fmt: skip
    """Closes the fingers step by step, and says whether the motors stalled on the way; they are left where they stand.

    Args:
        force_n: Brings the faces from where they were kept last to a distance, and gives the larger normal force [N].
        keep: The faces as they are now become those that `force_n` starts from.
        start: Distance of the faces where they stand [mm], at which they touch the object or will soon, and force [N].
        target_mm: Where to, not above it [mm].
        limit_n: Normal force at which the motors stall [N].
    """
    width, pressed = start
    if pressed > limit_n:
        return True
    while width > target_mm:
        tried = max(width - CREEP_MM, target_mm)
        found = force_n(tried)
        if found > limit_n:
            _stall(force_n, (tried, found), (width, pressed), limit_n)
            return True
        keep()
        width, pressed = tried, found
    return False


def _stall(
    force_n: Callable[[float], float], closer: tuple[float, float], wider: tuple[float, float], limit_n: float
) -> None:
    """Goes to where the force is the limit, between the distance where the faces are, above it, and one below it."""
    known, stands = dict([closer, wider]), closer[0]

    def excess_n(width_mm: float) -> float:
        nonlocal stands
        if width_mm not in known:
            known[width_mm], stands = force_n(width_mm), width_mm
        found = known[width_mm] - limit_n
        return 0.0 if abs(found) <= TOLERANCE * limit_n else found

    width = float(brentq(excess_n, closer[0], wider[0], xtol=FINEST_MM))
    if width != stands:
        force_n(width)


RANGES = {
    "link_mm": (5.0, 500.0), "pivot_mm": (0.0, 500.0), "pad_mm": (-500.0, 500.0), "least_deg": (-80.0, 80.0),
    "most_deg": (-80.0, 80.0), "speed_deg_s": (0.01, 3600.0), "force_limit_n": (0.01, 1000.0),
}  # fmt: skip
"""What each number may be."""
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """The parallelograms of both fingers, alike."""

    link_mm: float = 60.0
    """Length of the cranks, from the motor's axis to the finger's joint [mm]; assumed."""
    pivot_mm: float = 20.0
    """Distance of each motor's axis from the middle between the fingers [mm]; assumed."""
    pad_mm: float = 15.0
    """Distance from a finger's joint to its contact face, towards the other finger [mm]; assumed."""
    least_deg: float = -4.0
    """Angle at which the fingers are closed [degrees]; assumed."""
    most_deg: float = 50.0
    """Angle at which they are open [degrees]; assumed."""
    speed_deg_s: float = 40.0
    """Largest speed of a crank [degrees/s]; assumed."""
    force_limit_n: float = 12.0
    """Normal force at which a motor stalls [N]; assumed."""

    def __post_init__(self) -> None:
        """Checks the numbers (`ConfigError`), also that closed fingers do not pass through each other."""
        for field in fields(self):
            check_number(f"linkage.{field.name}", getattr(self, field.name), *RANGES[field.name])
        if self.least_deg >= self.most_deg:
            msg = f"linkage.least_deg = {self.least_deg:g} is not allowed: must be below most_deg = {self.most_deg:g}"
            raise ConfigError(msg)
        if self.width_mm(self.least_deg) <= 0:
            raise ConfigError(
                f"linkage.least_deg = {self.least_deg:g} is not allowed: the fingers would pass through each other "
                f"(distance of their faces {self.width_mm(self.least_deg):.3g} mm, must be above 0)"
            )

    def width_mm(self, angle_deg: float) -> float:
        """Distance of the contact faces at an angle [mm]."""
        return 2 * (self.pivot_mm + self.link_mm * math.sin(math.radians(angle_deg)) - self.pad_mm)

    def along_mm(self, angle_deg: float) -> float:
        """Way of both fingertips along the fingers' direction, from the motors' axes [mm]."""
        return self.link_mm * math.cos(math.radians(angle_deg))

    def angle_deg(self, width_mm: float) -> float:
        """The angle at which the faces are so far apart [degrees], which the fingers must reach (`ConfigError`)."""
        self.check(width_mm)
        sine = (width_mm / 2 + self.pad_mm - self.pivot_mm) / self.link_mm
        return math.degrees(math.asin(min(1.0, max(-1.0, sine))))

    def check(self, width_mm: float) -> None:
        """Refuses (`ConfigError`) a distance of the faces that the fingers do not reach, with their range."""
        low, high = self.width_mm(self.least_deg), self.width_mm(self.most_deg)
        if not low - ROUNDING <= width_mm <= high + ROUNDING:
            msg = f"width_mm = {width_mm:g} is not allowed: must be {low:.4g} to {high:.4g}, the range of the linkage"
            raise ConfigError(msg)

    def check_room(self, kind: str, thick_mm: float) -> None:
        """Refuses (`ConfigError`) an object that open fingers have no room for, with how far they open."""
        widest = self.width_mm(self.most_deg)
        if thick_mm >= widest:
            raise ConfigError(
                f"object '{kind}' does not fit between the fingers: {thick_mm:.4g} mm along the closing axis, and they "
                f"open to {widest:.4g} mm"
            )

    def turned_deg(self, angle_deg: float, target_deg: float, *, dt_s: float) -> float:
        """The angle after some time on the way to another, at no more than the largest speed [degrees]."""
        target = min(max(target_deg, self.least_deg), self.most_deg)
        most = self.speed_deg_s * dt_s
        return angle_deg + min(max(target - angle_deg, -most), most)
