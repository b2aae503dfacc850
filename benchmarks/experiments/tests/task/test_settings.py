import pytest

from magicsim.config.models import apply_overrides, validate
from magicsim.errors import ConfigError
from magicsim_experiments.task.alignment.grip import AlignmentConfig
from magicsim_experiments.task.running import task_scene
from magicsim_experiments.task.settings import GraspConfig, load_item
from magicsim_experiments.task.world import check_room_for


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("near_mm=[4,1]", "near_mm: 4, 1 is not allowed: must be the smaller one first"),
        ("hand_mm_s=[250,60]", "hand_mm_s: 250, 60 is not allowed: must be the smaller one first"),
        ("near_mm=[900,1000]", "near_mm = 900, 1000 is not allowed: must be at most 16, twice open_gap_mm"),
        ("scene=['object.kind=sphere']", "scene: 'object.kind=sphere' is not allowed: must be left to items"),
        ("scene=['references=0']", "scene: 'references=0' is not allowed: must be left to the detector's profile"),
        ("scene=['rig.room=dark']", "scene: 'rig.room=dark' is not allowed: must be left to room"),
        ("open_gap_mm=0.001", "near_mm = 1, 4 is not allowed: must be at most 0.002"),
    ],
)
def test_range_that_cannot_be_drawn_from_is_one_line(setting: str, named: str):
    with pytest.raises(ConfigError, match=named):
        validate(GraspConfig, apply_overrides({}, [setting]), source="task grasp")


def test_item_that_open_fingers_have_no_room_for_is_refused_before_they_are_built():
    item = load_item("orange")
    check_room_for(item, "orange", GraspConfig())
    with pytest.raises(ConfigError, match="open_gap_mm = 500 is not allowed with item 'orange': must be at most"):
        check_room_for(item, "orange", GraspConfig(open_gap_mm=500))
    wide = item.model_copy(update={"object": item.object.model_copy(update={"radius_mm": 60.0})})
    with pytest.raises(ConfigError, match="items: 'wide' is not allowed: 120 mm thick"):
        check_room_for(wide, "wide", GraspConfig())


def test_grasp_task_refuses_a_coat():
    config = GraspConfig(scene=("design.coat={kind='opaque',color=[0.4,0.4,0.4]}",))
    with pytest.raises(
        ConfigError, match=r"design = mini-magictac is not allowed with task grasp.*design.coat is opaque"
    ):
        task_scene(config, load_item("orange"))


def test_alignment_takes_its_angles_in_order():
    with pytest.raises(ConfigError, match="askew_deg: 20, 10 is not allowed: must be the smaller one first"):
        validate(AlignmentConfig, {"askew_deg": (20, 10)}, source="task alignment")
    with pytest.raises(ConfigError, match="scene: 'references=0' is not allowed: must be left to references"):
        validate(AlignmentConfig, {"scene": ("references=0",)}, source="task alignment")
