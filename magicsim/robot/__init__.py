"""A sensor whose world is moved by the user's code: live, as a camera, as a gripper, as a Gymnasium environment.

The names below are loaded when they are first used, so that importing the package stays light.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.robot.capture import SimulatedCapture
    from magicsim.robot.digit import DigitCamera
    from magicsim.robot.environment import GraspLift
    from magicsim.robot.gripper import Gripper
    from magicsim.robot.live import LiveSensor, live_sensor
    from magicsim.robot.workspace import Workspace

__all__ = ["DigitCamera", "GraspLift", "Gripper", "LiveSensor", "SimulatedCapture", "Workspace", "live_sensor"]

_HOMES = {
    "DigitCamera": "magicsim.robot.digit",
    "GraspLift": "magicsim.robot.environment",
    "Gripper": "magicsim.robot.gripper",
    "LiveSensor": "magicsim.robot.live",
    "SimulatedCapture": "magicsim.robot.capture",
    "Workspace": "magicsim.robot.workspace",
    "live_sensor": "magicsim.robot.live",
}


def __getattr__(name: str) -> object:
    """Loads a public name from its module."""
    if name not in _HOMES:
        msg = f"module 'magicsim.robot' has no attribute '{name}'"
        raise AttributeError(msg)
    found = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Names of the package, those not yet loaded included."""
    return sorted({*globals(), *__all__})
