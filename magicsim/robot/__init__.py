"""A sensor whose world is moved by the user's code: live, as a camera, as a gripper, as a Gymnasium environment.

The names below are loaded when they are first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.robot.capture import SimulatedCapture
    from magicsim.robot.digit import DigitCamera
    from magicsim.robot.environment import GraspLift
    from magicsim.robot.fingers import ObjectPlace
    from magicsim.robot.grip.linkage import Linkage
    from magicsim.robot.grip.load import Hold, Load
    from magicsim.robot.gripper import Gripper
    from magicsim.robot.live import LiveSensor, live_sensor
    from magicsim.robot.workspace import Workspace

__all__ = [
    "DigitCamera",
    "GraspLift",
    "Gripper",
    "Hold",
    "Linkage",
    "LiveSensor",
    "Load",
    "ObjectPlace",
    "SimulatedCapture",
    "Workspace",
    "live_sensor",
]

_HOMES = {
    "DigitCamera": "magicsim.robot.digit",
    "GraspLift": "magicsim.robot.environment",
    "Gripper": "magicsim.robot.gripper",
    "Hold": "magicsim.robot.grip.load",
    "Linkage": "magicsim.robot.grip.linkage",
    "LiveSensor": "magicsim.robot.live",
    "Load": "magicsim.robot.grip.load",
    "ObjectPlace": "magicsim.robot.fingers",
    "SimulatedCapture": "magicsim.robot.capture",
    "Workspace": "magicsim.robot.workspace",
    "live_sensor": "magicsim.robot.live",
}

__getattr__, __dir__ = lazy_names("magicsim.robot", _HOMES)
