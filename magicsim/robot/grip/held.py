"""An object under load between two fingers: where it rests, in all six directions, or that it drops."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.arrays import Array, Mask
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.robot.fingers import ObjectPlace, object_pose
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.grip.pair import FingerPair, contacts_mm
from magicsim.robot.grip.truth import GripState

ITERATIONS = 40
"""Most trials of one search."""
SHORTENINGS = 4
"""How often a step is shortened that fails, or goes too far."""
LONGEST_MM = 0.5
"""Longest step [mm]."""
WORSE = 1.5
"""What drives the body back after a step, in units of what drove it on before, above which the step is shortened; a
body that is still driven on goes on, however hard it is driven."""
SOFTEST = 0.02
"""Least stiffness along any direction, in units of the largest first estimate's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestingPlace:
    """Where a search ended."""

    place: Array
    """Shape (n,) [mm]."""
    is_balanced: bool = False
    """Whether it is at rest there within the tolerance; otherwise it slid farther than allowed, or is at a limit."""
    limit: int | None = None
    """The coordinate at whose limit it is driven on."""


def find_balance(
    unbalanced: Callable[[Array], Array], stiffness: Array, *, tolerance_n: float, low: Array, high: Array,
    most_mm: float, keep: Callable[[], None],
) -> RestingPlace:  # fmt: skip
    """Moves a body from 0 to where the force on it vanishes.

    Args:
        unbalanced: Force on the body at a place, both of shape (n,) [mm, N], rotations times a lever; the state behind
            is left there. It may raise ConvergenceError.
        stiffness: First estimate of how the force falls with the motion, shape (n, n) [N/mm].
        tolerance_n: Largest component out of balance at rest [N].
        low: Smallest place, shape (n,) [mm].
        high: Largest place, shape (n,); a coordinate without any range is held [mm].
        most_mm: Way from the start beyond which the body is lost [mm].
        keep: The state behind as it is now becomes the one that trials start from.

    Raises:
        ConvergenceError: The search did not end; the message has the figures.
    """
    matrix = np.array(stiffness, float)
    softest = SOFTEST * max(float(np.abs(np.diagonal(matrix)).max()), 1e-3)
    place, free = np.zeros(len(matrix)), low < high
    force, trials = unbalanced(place), 1
    while trials < ITERATIONS:
        if np.abs(force[free]).max(initial=0.0) <= tolerance_n:
            return RestingPlace(place=place, is_balanced=True)
        step = _step(matrix, force, free, softest)
        length = float(np.linalg.norm(step))
        is_long = length >= LONGEST_MM
        step *= min(1.0, LONGEST_MM / max(length, 1e-30))
        for shortening in range(SHORTENINGS + 1):
            tried = np.clip(place + step, low, high)
            try:
                found, trials = unbalanced(tried), trials + 1
            except ConvergenceError:
                if shortening == SHORTENINGS:
                    raise
                trials += 1
            else:
                matrix = _updated(matrix, tried - place, force - found)
                overshoots = found @ (tried - place) < 0
                if not overshoots or np.linalg.norm(found[free]) <= WORSE * np.linalg.norm(force[free]):
                    break
            step, is_long = step / 2, False
        place, force = tried, found
        if is_long:
            keep()
        is_at_limit = (place <= low) & (force < 0) | (place >= high) & (force > 0)
        stopped = is_at_limit & free & (np.abs(force) > tolerance_n)
        if stopped.any():
            return RestingPlace(place=place, limit=int(stopped.argmax()))
        if np.linalg.norm(place) > most_mm:
            return RestingPlace(place=place)
    raise ConvergenceError(
        f"the held object does not come to rest: {np.abs(force).max():.3g} N out of balance after {trials} trials, "
        f"{np.linalg.norm(place):.3g} mm from where it was"
    )


def _step(matrix: Array, force: Array, free: Mask, softest: float) -> Array:
    """Newton's step where the stiffness is definite; otherwise one along the force, soft directions stiffened."""
    step = np.zeros(len(force))
    part = matrix[np.ix_(free, free)]
    values, vectors = np.linalg.eigh((part + part.T) / 2)
    if values.min(initial=np.inf) > softest:
        step[free] = np.linalg.solve(part, force[free])
    else:
        step[free] = vectors @ ((vectors.T @ force[free]) / np.maximum(values, softest))
    return step


def _updated(matrix: Array, moved: Array, fallen: Array) -> Array:
    """Broyden's update (1965) of the stiffness by what a step has shown."""
    size = float(moved @ moved)
    if size == 0:
        return matrix
    return np.asarray(matrix + np.outer(fallen - matrix @ moved, moved) / size)


BALANCE_N, BALANCE_SHARE, LOAD_SHARE = 0.01, 0.01, 0.05
"""Force out of balance at which the object rests: in units of the larger normal force and of the load, of which the
smaller one counts, and at least so much [N]. Torques count by the levers of `FingerPair.levers_mm`."""
COORDINATES = ("x_mm", "y_mm", "z_mm", "tilt_x_deg", "tilt_y_deg", "twist_deg")
"""Coordinates of a place, in the order of the wrench."""


def settle(pair: FingerPair, place: ObjectPlace, width_mm: float, load: Load, *, most_slide_mm: float) -> GripState:
    """Lets the object go where fingers and load bring it; the fingers are left there, empty where it drops."""
    room = pair.room_mm(place, width_mm)
    touches_lower, touches_upper = contacts_mm(pair, place, width_mm)
    ended = GripState(width_mm=width_mm, place=place, hold=Hold.DROPPED, load=load)
    if touches_lower <= touches_upper:  # not pressed from both sides
        pair.take_away(width_mm)
        return ended
    first = replace(place, z_mm=float(np.clip(place.z_mm, touches_upper, touches_lower).clip(*room)))
    base = [pair.moments()]
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
    stiffness = pair.stiffness(first, width_mm) + load.stiffness(object_pose(pair.target, first))
    stiffness *= np.outer(scale, scale)
    found = find_balance(
        unbalanced, stiffness, tolerance_n=tolerance, low=low / scale, high=high / scale, most_mm=most_slide_mm,
        keep=keep,
    )  # fmt: skip
    settled = _inside(pair, _moved(first, found.place * scale))
    if not found.is_balanced:
        limit = None if found.limit is None else COORDINATES[found.limit]
        if limit == "z_mm":
            raise ConfigError(
                f"load is not allowed: it presses the object to z_mm = {settled.z_mm:.3g}; gaps of the workspace allow "
                f"{room[0]:.3g} to {room[1]:.3g}"
            )
        pair.take_away(width_mm)
        return replace(ended, place=settled, limit=limit)
    return replace(ended, hold=Hold.HELD, place=settled)


def _limits(pair: FingerPair, place: ObjectPlace, room: tuple[float, float]) -> tuple[Array, Array]:
    """Smallest and largest motion of the object that the upper finger's workspace allows, shape (6,) [mm, rad]."""
    space = pair.upper.workspace
    ranges = [room if name == "z_mm" else getattr(space, name) for name in COORDINATES]
    now = np.array([getattr(place, name) for name in COORDINATES])
    low, high = (np.array([each[end] for each in ranges]) - now for end in (0, 1))
    low[3:], high[3:] = np.radians(low[3:]), np.radians(high[3:])
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def _inside(pair: FingerPair, place: ObjectPlace) -> ObjectPlace:
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
    turned = Rotation.from_rotvec(motion[3:]) * old
    _, _, z, w = turned.as_quat()
    twist = float(np.degrees(2 * np.arctan2(z, w)))
    twist += 360.0 * round((place.twist_deg - twist) / 360.0)
    swing = turned * Rotation.from_euler("z", -twist, degrees=True)
    tilt_x, tilt_y, _ = swing.as_rotvec(degrees=True)
    return replace(
        place, x_mm=place.x_mm + float(motion[0]), y_mm=place.y_mm + float(motion[1]),
        z_mm=place.z_mm + float(motion[2]), twist_deg=twist, tilt_x_deg=float(tilt_x), tilt_y_deg=float(tilt_y),
    )  # fmt: skip
