"""An object under load between two fingers: where it rests, in all six directions, or that it drops."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim.robot.fingers import ObjectPlace, object_pose
from magicsim.robot.grip.balance import Limits, Search, find_balance
from magicsim.robot.grip.floating import contacts_mm
from magicsim.robot.grip.load import Load
from magicsim.robot.grip.outcome import Hold
from magicsim.robot.grip.pair import Pair

BALANCE_N, BALANCE_SHARE, LOAD_SHARE = 0.01, 0.01, 0.05
"""Force out of balance at which the object rests: in units of the larger normal force and of the load, of which the
smaller one counts, and at least so much [N]. Torques count by the levers of `Pair.levers_mm`."""
COORDINATES = ("x_mm", "y_mm", "z_mm", "tilt_x_deg", "tilt_y_deg", "twist_deg")
"""Coordinates of a place, in the order of the wrench."""
FULL_TURN = 360.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """What became of the object."""

    hold: Hold
    place: ObjectPlace
    """Where it is, or was last."""
    slid_mm: float
    """How far it slid over the skin that it slid over most [mm]."""
    trials: int
    """Equilibria of both fingers that were solved for it."""
    limit: str | None = None
    """The coordinate at whose end in the workspace it was still driven on; it counts as dropped there."""


def settle(pair: Pair, place: ObjectPlace, width_mm: float, load: Load, *, most_slide_mm: float) -> Held:
    """Lets the object go where fingers and load bring it; the fingers are left there, empty where it drops.

    Args:
        pair: The fingers.
        place: Where the object is.
        width_mm: Distance between the contact faces [mm].
        load: On the object.
        most_slide_mm: Way of the object in one motion beyond which it counts as dropped [mm].

    Raises:
        ConfigError: The object does not fit, or the load presses it deeper than the workspace goes.
        ConvergenceError: No valid equilibrium of a finger was found.
    """
    room = pair.room_mm(place, width_mm)
    touches_lower, touches_upper = contacts_mm(pair, place, width_mm)
    if touches_lower <= touches_upper:  # not pressed from both sides
        pair.take_away(width_mm)
        return Held(hold=Hold.DROPPED, place=place, slid_mm=0.0, trials=0)
    start, slid = pair.moments(), pair.slid_mm
    first = replace(place, z_mm=float(np.clip(place.z_mm, touches_upper, touches_lower).clip(*room)))
    base = [start]
    pair.put(first, width_mm)
    levers = pair.levers_mm(first)
    scale = np.concatenate([np.ones(3), 1 / levers])
    carried = float(np.linalg.norm(load.wrench(object_pose(pair.target, first)) * scale))
    tolerance = max(BALANCE_N, min(BALANCE_SHARE * pair.normal_n, LOAD_SHARE * carried))

    def unbalanced(way: Array) -> Array:
        moved = _inside(pair, _moved(first, way * scale))
        pair.go_back(base[0])
        pair.put(moved, width_mm)
        wrench = pair.wrench(moved, width_mm) + load.wrench(object_pose(pair.target, moved))
        return np.asarray(wrench * scale)

    def keep() -> None:
        base[0] = pair.moments()

    low, high = _limits(pair, first, room)
    limits = Limits(tolerance_n=tolerance, most_mm=most_slide_mm, low=low / scale, high=high / scale)
    stiffness = pair.stiffness(first, width_mm) + load.stiffness(object_pose(pair.target, first))
    stiffness *= np.outer(scale, scale)
    found = find_balance(unbalanced, stiffness, limits, keep=keep)
    settled = _inside(pair, _moved(first, found.place * scale))
    way = max(now - before for now, before in zip(pair.slid_mm, slid, strict=True))
    if found.search is not Search.BALANCED:
        limit = None if found.limit is None else COORDINATES[found.limit]
        if limit == "z_mm":
            msg = (
                f"load is not allowed: it presses the object to z_mm = {settled.z_mm:.3g}; gaps of the workspace allow "
                f"{room[0]:.3g} to {room[1]:.3g}"
            )
            raise ConfigError(msg)
        pair.take_away(width_mm)
        return Held(hold=Hold.DROPPED, place=settled, slid_mm=way, trials=found.trials, limit=limit)
    return Held(hold=Hold.of_way(way), place=settled, slid_mm=way, trials=found.trials)


def _limits(pair: Pair, place: ObjectPlace, room: tuple[float, float]) -> tuple[Array, Array]:
    """Smallest and largest motion of the object that the upper finger's workspace allows, shape (6,) [mm, rad]."""
    space = pair.upper.workspace
    ranges = (space.x_mm, space.y_mm, room, space.tilt_x_deg, space.tilt_y_deg, space.twist_deg)
    now = (place.x_mm, place.y_mm, place.z_mm, place.tilt_x_deg, place.tilt_y_deg, place.twist_deg)
    low, high = (np.array([each[end] - at for each, at in zip(ranges, now, strict=True)]) for end in (0, 1))
    low[3:], high[3:] = np.radians(low[3:]), np.radians(high[3:])
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def _inside(pair: Pair, place: ObjectPlace) -> ObjectPlace:
    """The place with its angles in the upper finger's workspace: rotations do not add up exactly."""
    space, angles = pair.upper.workspace, ("twist_deg", "tilt_x_deg", "tilt_y_deg")
    inside = {name: float(np.clip(getattr(place, name), *getattr(space, name))) for name in angles}
    return replace(place, **inside)


def _moved(place: ObjectPlace, motion: Array) -> ObjectPlace:
    """The place after a motion of the origin [mm] and a rotation vector [rad] about it, shape (6,).

    The rotation is split into a twist about z and a tilt after it (swing and twist).
    """
    old = Rotation.from_rotvec([place.tilt_x_deg, place.tilt_y_deg, 0.0], degrees=True) * Rotation.from_euler(
        "z", place.twist_deg, degrees=True
    )
    x, y, z, w = (Rotation.from_rotvec(motion[3:]) * old).as_quat()
    del x, y
    twist = float(np.degrees(2 * np.arctan2(z, w)))
    twist += FULL_TURN * round((place.twist_deg - twist) / FULL_TURN)
    swing = Rotation.from_rotvec(motion[3:]) * old * Rotation.from_euler("z", -twist, degrees=True)
    tilt_x, tilt_y, _ = swing.as_rotvec(degrees=True)
    return replace(
        place, x_mm=place.x_mm + float(motion[0]), y_mm=place.y_mm + float(motion[1]),
        z_mm=place.z_mm + float(motion[2]), twist_deg=twist, tilt_x_deg=float(tilt_x), tilt_y_deg=float(tilt_y),
    )  # fmt: skip
