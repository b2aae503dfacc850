"""What gripper and carriage do in each stage of the published grasp machine."""

from dataclasses import dataclass
from typing import Literal

from magicsim.detectors.grasp import GraspStage

RELEASE_FRAMES = 2
"""Frames at B before the gripper opens on purpose."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Motion of the next frame."""

    fingers: Literal["close", "open", "stay"]
    carriage: Literal["to_b", "to_a", "stay"]


def command(stage: GraspStage, *, is_open: bool) -> Command:
    """What to do in a stage: closing ends where the motors stall; the carriage goes back with open fingers only.

    Args:
        stage: Of the machine.
        is_open: Whether the fingers are as far open as they were at the start.
    """
    if stage is GraspStage.WAITING:
        return Command(fingers="stay" if is_open else "open", carriage="to_a")
    if stage is GraspStage.TRANSPORTING:
        return Command(fingers="close", carriage="to_b")
    if stage in (GraspStage.CLOSING, GraspStage.GRASPED):
        return Command(fingers="close", carriage="stay")
    return Command(fingers="open", carriage="to_a" if is_open else "stay")
