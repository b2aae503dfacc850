"""Both fingers at once: the object put between them, what they do to it, and back to where they were.

An object without weight moves along the closing axis until both normal forces are equal.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.geometry.pose import Pose
from magicsim.robot.darkroom import Moment
from magicsim.robot.fingers import SIDES, ObjectPlace, finger_motion, finger_pose, half_extents_mm, object_pose
from magicsim.robot.live import LiveSensor
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.episode import FrameTruth

SHEAR_SHARE = 2 / 3
"""Tangential by normal stiffness of a bonded round contact on an incompressible half space: (2 - 2 v) / (2 - v) at v =
1/2 (Mindlin 1949)."""
HERTZ = 1.5
"""Power of the depth with which the force of a ball on a half space rises; its stiffness in units of force by depth."""


def finger_wrench(touch: Deformation | FrameTruth, finger: Pose, origin_mm: Array) -> Array:
    """Force [N] and torque [N mm] of a finger on the object about its origin, in the gripper's frame, shape (6,)."""
    force = -finger.rotation @ np.asarray(touch.force_n)
    torque = np.cross(finger.position_mm - origin_mm, force) - finger.rotation @ np.asarray(touch.torque_nmm)
    return np.concatenate([force, torque])


def both_wrench(touches: Iterable[Deformation | FrameTruth], width_mm: float, place: ObjectPlace) -> Array:
    """Force [N] and torque about its origin [N mm] of both fingers, upper first, on the object, shape (6,)."""
    origin = np.array([place.x_mm, place.y_mm, place.z_mm])
    each = (
        finger_wrench(touch, finger_pose(side, width_mm), origin) for side, touch in zip(SIDES, touches, strict=True)
    )
    return np.asarray(sum(each, np.zeros(6)))


def contact_stiffness(deformation: Deformation, depth_mm: float, finger: Pose, origin_mm: Array) -> Array:
    """First estimate of how a finger's wrench answers small motions of the object, shape (6, 6) [N/mm, N, N mm].

    A round contact on a half space, sticking, of the force, depth and area that the equilibrium has.
    """
    force = float(deformation.force_n[2])
    if force <= 0 or depth_mm <= 0:
        return np.zeros((6, 6))
    normal = HERTZ * force / depth_mm
    square = deformation.contact_area_mm2 / np.pi
    own = np.array([SHEAR_SHARE, SHEAR_SHARE, 1.0, square / 3, square / 3, SHEAR_SHARE * square / 2]) * normal
    weight = deformation.contact_pressure_mpa
    centre = (weight @ deformation.contact_points_mm) / weight.sum()
    x, y, z = finger.to_sensor(centre[None])[0] - origin_mm
    carried = np.eye(6)  # motion of the contact's centre by that of the origin: u + theta x r
    carried[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return np.asarray(carried.T @ np.diag(own) @ carried)


Moments = tuple[Moment, Moment]
LEAST_LEVER_MM = 1.0
"""Least lever of a rotation [mm]."""


class FingerPair:
    """The two sensors and the object, in the gripper's frame."""

    def __init__(self, upper: LiveSensor, lower: LiveSensor, target: AnyObject, *, sees_other: bool) -> None:
        self.upper, self.lower, self.target = upper, lower, target
        self._sees_other = sees_other

    @property
    def fingers(self) -> tuple[LiveSensor, LiveSensor]:
        """Upper and lower."""
        return self.upper, self.lower

    def reaches_mm(self, place: ObjectPlace) -> tuple[float, float]:
        """How far the object's origin is from the crowns of the upper and the lower face as it first touches each [mm].

        Before a flat face that is how far the object reaches; a curved one recedes from it beside the crown.
        """
        up, down = half_extents_mm(self.target, place)
        recedes = []
        for side, finger in zip(SIDES, self.fingers, strict=True):
            motion = finger_motion(side, place, 0.0, (0.0, 0.0)) | {"gap_mm": 0.0}
            state = replace(UNTOUCHED, **motion)  # type: ignore[arg-type]
            touching = finger.sensor.indenter(state) if finger.sensor.design.face is not None else None
            recedes.append(0.0 if touching is None else touching.top_mm())
        return up - recedes[0], down - recedes[1]

    def put(self, place: ObjectPlace, width_mm: float) -> None:
        """Brings the faces to a distance and the object to a place.

        `ConfigError` where it would leave a finger's workspace, `ConvergenceError` without a valid equilibrium.
        """
        reaches = self.reaches_mm(place)
        for side, finger in zip(SIDES, self.fingers, strict=True):
            finger.move_to(**finger_motion(side, place, width_mm, reaches))
        self.face(width_mm)

    def take_away(self, width_mm: float) -> None:
        """Removes the object from both, the faces at a distance [mm]."""
        for finger in self.fingers:
            finger.remove_object()
        self.face(width_mm)

    def face(self, width_mm: float) -> None:
        """Shows each finger the other one at a distance of the faces [mm]."""
        for finger in self.fingers if self._sees_other else ():
            finger.face(width_mm)

    def moments(self) -> Moments:
        """Where both are."""
        return self.upper.now(), self.lower.now()

    def go_back(self, moments: Moments) -> None:
        """Brings both back to where they were."""
        for finger, moment in zip(self.fingers, moments, strict=True):
            finger.go_back(moment)

    def wrench(self, place: ObjectPlace, width_mm: float) -> Array:
        """What both fingers do to the object, see `both_wrench`."""
        return both_wrench((finger.deformation for finger in self.fingers), width_mm, place)

    def stiffness(self, place: ObjectPlace, width_mm: float) -> Array:
        """First estimate of how that wrench falls with motions of the object, shape (6, 6)."""
        origin, found = object_pose(self.target, place).position_mm, np.zeros((6, 6))
        for side, finger in zip(SIDES, self.fingers, strict=True):
            depth = max(0.0, -(finger.state.gap_mm or 0.0))
            found += contact_stiffness(finger.deformation, depth, finger_pose(side, width_mm), origin)
        return found

    def levers_mm(self, place: ObjectPlace) -> Array:
        """Lengths that turn rotations into motions of the contacts, shape (3,) [mm]: about x, y and z."""
        tilt = max(LEAST_LEVER_MM, *half_extents_mm(self.target, place))
        area = max(finger.deformation.contact_area_mm2 for finger in self.fingers)
        return np.array([tilt, tilt, max(LEAST_LEVER_MM, np.sqrt(area / np.pi))])

    @property
    def normal_n(self) -> float:
        """Larger of the two normal forces [N]."""
        return max(float(finger.deformation.force_n[2]) for finger in self.fingers)

    @property
    def slid_mm(self) -> tuple[float, float]:
        """How far each skin has slid over the object since its stream began [mm]."""
        return self.upper.slid_mm, self.lower.slid_mm

    def closing_mm(self, place: ObjectPlace, *, floats: bool) -> tuple[float, float]:
        """Distances of the faces where the first one touches the object and down to which the workspaces go [mm]."""
        up, down = self.reaches_mm(place)
        (deepest_up, _), (deepest_down, _) = (finger.workspace.gap_mm for finger in self.fingers)
        if floats:
            return up + down, up + down + deepest_up + deepest_down
        above, below = up + place.z_mm, down - place.z_mm
        return 2 * max(above, below), 2 * max(above + deepest_up, below + deepest_down)

    def room_mm(self, place: ObjectPlace, width_mm: float) -> tuple[float, float]:
        """Smallest and largest z of the object at which both workspaces hold it [mm]; `ConfigError` without any."""
        up, down = self.reaches_mm(place)
        (up_low, up_high), (down_low, down_high) = (finger.workspace.gap_mm for finger in self.fingers)
        low = max(width_mm / 2 - up - up_high, down + down_low - width_mm / 2)
        high = min(width_mm / 2 - up - up_low, down + down_high - width_mm / 2)
        if low > high:
            raise ConfigError(
                f"width_mm = {width_mm:.4g} is not allowed: the object does not fit, {up + down:.4g} mm between the "
                f"faces, which gaps of {up_low:g} to {up_high:g} mm and {down_low:g} to {down_high:g} mm leave no room"
            )
        return low, high


def finger_seed(seed: int, number: int) -> int:
    """The seed of one finger's noise, from the gripper's and the finger's number."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0] >> 1)


BALANCE_N = 0.01
"""Difference of the two normal forces at which a floating object rests [N]."""
FINEST_MM = 1e-6
"""Interval of places at which the search for balance ends in any case [mm]."""
BEYOND = 1.3
"""How far the step after the guess goes, in units of the secant's, so that balance lies before its end."""


def contacts_mm(pair: FingerPair, place: ObjectPlace, width_mm: float) -> tuple[float, float]:
    """Heights of the object at which it just touches the lower and the upper finger [mm]; none where not in order."""
    up, down = pair.reaches_mm(place)
    return down - width_mm / 2, width_mm / 2 - up


def float_between(pair: FingerPair, place: ObjectPlace, width_mm: float) -> ObjectPlace:
    """Where the object comes to rest; the fingers are left there. Errors are those of `put`."""
    touches_lower, touches_upper = contacts_mm(pair, place, width_mm)
    if touches_lower <= touches_upper:  # room for the object: a finger that touches it pushes it away
        settled = replace(place, z_mm=min(max(place.z_mm, touches_lower), touches_upper))
        pair.put(settled, width_mm)
        return settled
    before = pair.moments()
    deepest = -pair.upper.workspace.gap_mm[0]
    low, high = max(touches_upper, touches_lower - deepest), min(touches_lower, touches_upper + deepest)
    tried: dict[float, tuple[float, Moments]] = {}

    def imbalance_n(z_mm: float) -> float:
        """Difference of the normal forces with the object at a place, 0 where they balance; fingers stay there."""
        if z_mm not in tried:
            pair.go_back(before)
            pair.put(replace(place, z_mm=z_mm), width_mm)
            found = float(pair.upper.deformation.force_n[2] - pair.lower.deformation.force_n[2])
            tried[z_mm] = (0.0 if abs(found) <= BALANCE_N else found, pair.moments())
        value, moments = tried[z_mm]
        pair.go_back(moments)
        return value

    settled_mm = (low + high) / 2
    at_middle = imbalance_n(settled_mm)
    if at_middle != 0:
        both_n = float(pair.upper.deformation.force_n[2] + pair.lower.deformation.force_n[2])
        guess = settled_mm - at_middle * (touches_lower - touches_upper) / 2 / (HERTZ * both_n)
        ends = _around(imbalance_n, settled_mm, min(max(guess, low), high), (low, high))
        if imbalance_n(ends[0]) <= 0 <= imbalance_n(ends[1]):
            settled_mm = float(brentq(imbalance_n, *ends, xtol=FINEST_MM))
        else:  # as near to balance as the workspace lets it come
            settled_mm = ends[0] if at_middle > 0 else ends[1]
        imbalance_n(settled_mm)
    return replace(place, z_mm=settled_mm)


def _around(
    imbalance_n: Callable[[float], float], middle_mm: float, guess_mm: float, farthest_mm: tuple[float, float]
) -> tuple[float, float]:
    """Two places with balance between them, near a guess where that is good, so that no finger is pressed deeply."""
    at_middle, at_guess = imbalance_n(middle_mm), imbalance_n(guess_mm)
    if at_guess * at_middle > 0 and at_guess != at_middle:
        step = BEYOND * at_guess * (guess_mm - middle_mm) / (at_guess - at_middle)
        middle_mm, guess_mm = guess_mm, min(max(guess_mm - step, farthest_mm[0]), farthest_mm[1])
        at_guess = imbalance_n(guess_mm)
    if at_guess * at_middle > 0:
        guess_mm = farthest_mm[0] if at_middle > 0 else farthest_mm[1]
    return min(middle_mm, guess_mm), max(middle_mm, guess_mm)
