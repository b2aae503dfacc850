"""Sensors on a MuJoCo model: body poses in, contact wrenches and frames out.

Needs the extra `mujoco`. The names below are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.robot.mujoco.coupling import Coupling
    from magicsim.robot.mujoco.pair import Touch, compiled

__all__ = ["Coupling", "Touch", "compiled"]

_HOMES = {
    "Coupling": "magicsim.robot.mujoco.coupling",
    "Touch": "magicsim.robot.mujoco.pair",
    "compiled": "magicsim.robot.mujoco.pair",
}

__getattr__, __dir__ = lazy_names("magicsim.robot.mujoco", _HOMES)
