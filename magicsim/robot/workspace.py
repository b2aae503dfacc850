"""Where an object may be moved: declared before the sensor is built, because the lattice is fine only there."""

import math
from dataclasses import dataclass, replace
from itertools import product

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE
from magicsim.geometry.objects.rigid_object import MOST_TWIST_DEG
from magicsim.scenes.lamps import FARTHEST_MM
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState

Range = tuple[float, float]
TWIST_STEP_DEG = 30.0
"""Twists at which the touched part of the face is looked up [degrees]: a rectangle turned half as far is 3.4 % of its
half diagonal wider at most, less than the fine lattice's margin."""
MOST_TILT_DEG = 45.0
"""Largest tilt along each axis: contact is by the side that faces the finger [degrees]."""
FARTHEST = {"twist_deg": MOST_TWIST_DEG, "tilt_x_deg": MOST_TILT_DEG, "tilt_y_deg": MOST_TILT_DEG}
"""Limits of the ranges that are angles [degrees]."""
RANGES = ("x_mm", "y_mm", "twist_deg", "tilt_x_deg", "tilt_y_deg", "gap_mm")
"""Coordinates of a pose that have a range."""
ROUNDING = 1e-9
"""Poses beyond a limit by no more than this are on it [mm, degrees]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Workspace:
    """Smallest and largest value of each coordinate of the object's pose, in the sensor's frame."""

    x_mm: Range = (-2.0, 2.0)
    """Object's origin along x [mm]."""
    y_mm: Range = (-2.0, 2.0)
    """Object's origin along y [mm]."""
    twist_deg: Range = (-90.0, 90.0)
    """Rotation about z [degrees]."""
    tilt_x_deg: Range = (0.0, 0.0)
    """Tilt, a rotation vector, along x [degrees]. The ranges of x and y say where the lattice is fine, tilts do not."""
    tilt_y_deg: Range = (0.0, 0.0)
    """Along y [degrees]."""
    gap_mm: Range = (-2.0, 30.0)
    """Distance of the object's highest point from the undeformed contact face [mm], negative when pressed."""
    beyond_mm: float = 0.0
    """How far beyond the ranges of x and y an object may be that does not press: on its way there [mm]."""

    def __post_init__(self) -> None:
        """Checks the limits.

        Raises:
            ConfigError: A limit is not allowed, or a pair is not in order.
        """
        check_number("workspace.beyond_mm", self.beyond_mm, 0, FARTHEST_MM)
        for name in RANGES:
            low, high = getattr(self, name)
            farthest = FARTHEST.get(name, FARTHEST_MM)
            for limit in (low, high):
                check_number(f"workspace.{name}", limit, -farthest, farthest)
            if low > high:
                msg = f"workspace.{name} = ({low:g}, {high:g}) is not allowed: must be the smaller one first"
                raise ConfigError(msg)

    def check(self, state: FrameState) -> None:
        """Refuses a pose outside of the limits; a state without an object is always inside.

        Raises:
            ConfigError: Names the coordinate and its range.
        """
        beyond = self.beyond_mm if (state.gap_mm or 0) >= 0 else 0.0  # as for contact, 0 does not press
        for name in RANGES if state.has_object else ():
            value, (low, high) = getattr(state, name), getattr(self, name)
            slack = ROUNDING + (beyond if name in {"x_mm", "y_mm"} else 0.0)
            if not low - slack <= value <= high + slack:
                raise ConfigError(
                    f"{name} = {value:g} is not allowed: must be {low:g} to {high:g}, the workspace that this "
                    "sensor was built for"
                )

    def corners(self) -> tuple[FrameState, ...]:
        """States that bound where the object can touch: every corner at the deepest press, and twists between."""
        low, high = self.twist_deg
        count = math.ceil((high - low) / TWIST_STEP_DEG)
        twists = [low + (high - low) * step / count for step in range(count + 1)] if count else [low]
        poses = product(sorted(set(self.x_mm)), sorted(set(self.y_mm)), twists)
        return tuple(
            replace(UNTOUCHED, gap_mm=self.gap_mm[0], x_mm=x, y_mm=y, twist_deg=twist) for x, y, twist in poses
        )

    def states(self, scene: SceneConfig) -> tuple[FrameState, ...]:
        """Where a scene's object may touch: the corners; nothing without an object.

        Raises:
            ConfigError: The workspace goes deeper than the block allows.
        """
        if scene.object is None:
            return ()
        deepest, limit = -self.gap_mm[0], MAX_DEPTH_SHARE * scene.design.height_mm
        if deepest > limit:
            raise ConfigError(
                f"workspace.gap_mm = {self.gap_mm[0]:g} is not allowed: must be at least {-limit:g}, 90 % of the "
                "block's height"
            )
        return self.corners()
