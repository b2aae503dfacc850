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
    "DigitCamera", "GraspLift", "Gripper", "Hold", "Linkage", "LiveSensor", "Load", "ObjectPlace",
    "SimulatedCapture", "Workspace", "live_sensor",
]  # fmt: skip
