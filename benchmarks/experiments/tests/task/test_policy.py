import pytest

from magicsim.detectors.grasp import GraspStage
from magicsim_experiments.task.episode import command


@pytest.mark.parametrize(
    ("stage", "is_open", "fingers", "carriage"),
    [
        (GraspStage.WAITING, True, "stay", "to_a"),
        (GraspStage.CLOSING, True, "close", "stay"),
        (GraspStage.GRASPED, False, "close", "stay"),
        (GraspStage.TRANSPORTING, False, "close", "to_b"),
        (GraspStage.SLIPPED, False, "open", "stay"),
        (GraspStage.RETURNING, False, "open", "stay"),
        (GraspStage.RETURNING, True, "open", "to_a"),
    ],
)
def test_stage_drives_fingers_and_carriage(stage: GraspStage, is_open: bool, fingers: str, carriage: str):
    found = command(stage, is_open=is_open)
    assert (found.fingers, found.carriage) == (fingers, carriage)
