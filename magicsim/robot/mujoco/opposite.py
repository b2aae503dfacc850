"""Where the sensor stands that faces another one in a model."""

import numpy as np

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim.robot.fingers import TO_GRIPPER
from magicsim.robot.live import LEAST_WIDTH_MM
from magicsim.robot.mujoco.engine import MjData
from magicsim.robot.mujoco.solids import MM
from magicsim.scenes.rig import FARTHEST_MM

MOST_TURN_DEG, MOST_ASIDE_MM = 5.0, 2.0
"""How far from face to face two sensors may stand that are drawn so, half a turn about y apart."""
AXES = 3


def facing_distance_mm(data: MjData, own: int, other: int, names: tuple[str, str]) -> float:
    """Distance of the contact faces of two sensors that look at each other [mm].

    Args:
        data: With positions of all sites.
        own: Site of the one.
        other: Site of the other.
        names: Of both.

    Raises:
        ConfigError: They do not face each other.
    """
    turn, facing = (np.asarray(data.site_xmat[site], float).reshape(AXES, AXES) for site in (own, other))
    apart: Array = MM * turn.T @ (data.site_xpos[other] - data.site_xpos[own])
    between = TO_GRIPPER["lower"] @ turn.T @ facing
    turned = float(np.degrees(np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))))
    aside, distance = float(np.hypot(apart[0], apart[1])), -float(apart[2])
    if turned > MOST_TURN_DEG or aside > MOST_ASIDE_MM or not LEAST_WIDTH_MM <= distance <= FARTHEST_MM:
        msg = (
            f"site '{names[0]}' does not face site '{names[1]}' at {data.time:.3f} s: {turned:.3g} degrees from half a "
            f"turn about y, {aside:.3g} mm aside, {distance:.3g} mm apart; must be at most {MOST_TURN_DEG:g} degrees "
            f"and {MOST_ASIDE_MM:g} mm, {LEAST_WIDTH_MM:g} to {FARTHEST_MM:g} mm apart"
        )
        raise ConfigError(msg)
    return distance
