"""Where an object may be moved: declared before the sensor is built, because the lattice is fine only there."""

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE
from magicsim.geometry.objects.rigid_object import MOST_TWIST_DEG
from magicsim.geometry.pose import Pose
from magicsim.scenes.rig import FARTHEST_MM
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

ENTRY_STEP_MM = 0.1
"""Length of a step of an oblique way into contact [mm]."""
SLIDE_STEP_MM = 0.5
"""Length of a step within contact [mm]: a contact wider than that overlaps itself from step to step, so that its slip
can be added up; it is as long as the solver's own steps."""


def waypoints(
    start: FrameState, end: FrameState, *, has_friction: bool, reach_mm: float, lever_mm: float = 0.0
) -> list[FrameState]:
    """States to solve in order, the last one being the end; none when nothing can touch there.

    Without friction an equilibrium does not depend on the way. With it, the way is followed from the moment of contact:
    the skin is dragged along, on an oblique way in as well.

    The object touches within `reach_mm` of the vertical through its origin, farther by a tilt, as it is `lever_mm`
    high.
    """
    if not end.can_touch:
        return []
    if not has_friction or start.gap_mm is None or end.gap_mm is None:
        return [end]
    turn = math.radians(abs(end.twist_deg - start.twist_deg)) * reach_mm
    tilt = math.hypot(end.tilt_x_deg - start.tilt_x_deg, end.tilt_y_deg - start.tilt_y_deg)
    turn += math.radians(tilt) * lever_mm
    sideways = math.hypot(end.x_mm - start.x_mm, end.y_mm - start.y_mm) + turn
    is_inside = start.can_touch
    if sideways == 0 and not is_inside:
        return [end]
    first = 0.0 if is_inside else start.gap_mm / (start.gap_mm - end.gap_mm)
    length = (1 - first) * math.hypot(sideways, end.gap_mm - start.gap_mm)
    count = max(1, math.ceil(length / (SLIDE_STEP_MM if is_inside else ENTRY_STEP_MM)))
    shares = [first + (1 - first) * step / count for step in range(1, count)]
    return [*(between(start, end, share) for share in shares), end]


def between(start: FrameState, end: FrameState, share: float) -> FrameState:
    """The pose at a share of the straight way between two states that have an object; lights are those of the end."""
    values = {name: (1 - share) * getattr(start, name) + share * getattr(end, name) for name in RANGES}
    return replace(end, **values)


def slip_share(deformation: Deformation, area_mm2: Array) -> float:
    """Share of the normal force that presses on sliding points, 0 without contact, 1 in full slip."""
    if deformation.is_rest:
        return 0.0
    force = area_mm2 * deformation.contact_pressure_mpa
    total = float(force.sum())
    return float(force[deformation.is_slipping].sum()) / total if total > 0 else 0.0


def slip_mm(before: Deformation, after: Deformation, area_mm2: Array) -> float:
    """How far the skin slid over the object between two equilibria, the mean over the contact [mm].

    A sticking point keeps its anchor in the object's frame and a sliding one drags it along (see
    `magicsim.deform.contact.friction`), so the anchors' way is the way of sliding. Points count by their normal force
    after.
    """
    if before.is_rest or after.is_rest:
        return 0.0
    touching = (before.contact_pressure_mpa > 0) & (after.contact_pressure_mpa > 0)
    weight = (area_mm2 * after.contact_pressure_mpa)[touching]
    way = np.linalg.norm((after.anchors_mm - before.anchors_mm)[touching], axis=1)
    total = float(weight.sum())
    return float(weight @ way) / total if total > 0 else 0.0


def travel(
    sensor: Sensor, start: FrameState, end: FrameState, deformation: Deformation, area_mm2: Array
) -> tuple[Deformation, float]:
    """The equilibrium at the end of a straight motion, and the way of slip until then [mm]."""
    slid_mm, has_friction = 0.0, sensor.contact.friction > 0
    reach = sensor.lattice.zone.radius_mm if sensor.lattice.zone is not None else 0.0
    if not start.can_touch:
        deformation = sensor.rest
    lever = 0.0
    if (target := sensor.object) is not None:
        upright = Pose.from_degrees(np.zeros(3), roll=target.roll_deg, pitch=target.pitch_deg)
        lever = target.shape().support_mm(upright.rotation[2])
    way = waypoints(start, end, has_friction=has_friction, reach_mm=reach, lever_mm=lever)
    for each in way:
        before, deformation = deformation, sensor.deform(each, deformation)
        slid_mm += slip_mm(before, deformation, area_mm2)
    return sensor.rest if deformation.is_rest or not way else deformation, slid_mm


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
        """Checks (`ConfigError`) that limits are allowed and pairs in order."""
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
        """Refuses (`ConfigError`) a pose outside of the limits; a state without an object is always inside."""
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
        """Where a scene's object may touch, as deep as the block allows (`ConfigError`): corners, none without one."""
        if scene.object is None:
            return ()
        deepest, limit = -self.gap_mm[0], MAX_DEPTH_SHARE * scene.design.height_mm
        if deepest > limit:
            raise ConfigError(
                f"workspace.gap_mm = {self.gap_mm[0]:g} is not allowed: must be at least {-limit:g}, 90 % of the "
                "block's height"
            )
        return self.corners()
