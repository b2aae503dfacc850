import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.assembly.stages import TrialStage, draw_misalignments, split_settings, timeline


def test_settings_of_the_task_reach_jack_contact_stages_and_misalignments():
    settings = [
        "task.jack.radius_mm=2.8", "rig.room='dark'", "task.contact.friction=0.4", "task.push_n=[1, 6]",
        "task.offset_mm=[1,2]",
    ]  # fmt: skip
    scene, config = split_settings(settings)
    assert scene == ["rig.room='dark'"]
    assert (config.jack.radius_mm, config.contact.friction) == (2.8, 0.4)
    pushes = {step.stage: step.push_n for step in timeline(config)}
    assert (pushes[TrialStage.FIRST], pushes[TrialStage.SECOND]) == (1, 6)
    drawn = [each for each in draw_misalignments(60, 3, config) if each.kind == "offset"]
    assert all(1 <= (each.x_mm**2 + each.z_mm**2) ** 0.5 <= 2 for each in drawn)


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("task.offset_mm=[3,1]", "must be the smaller one first"),
        ("task.jack.depth_mm=0", "jack.depth_mm = 0 is not allowed"),
        ("task.jack.depth_mm=6", "success_mm = 8 is not allowed: must be at most 6"),
        ("task.speed=3", "speed"),
    ],
)
def test_impossible_settings_are_refused(setting: str, told: str):
    with pytest.raises(ConfigError, match=told):
        split_settings([setting])
