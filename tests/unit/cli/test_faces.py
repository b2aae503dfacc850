"""What a face, a coat, markers or an LED cannot be is one line with the field and what is allowed."""

import pytest

from magicsim.errors import ConfigError
from magicsim.evaluation.suite import load_suite
from magicsim.task.item import load_item
from magicsim.task.running import task_scene
from magicsim.task.settings import GraspConfig

from .conftest import Shell

TALL_DOME = "design.face={kind='dome',radius_x_mm=40.0,radius_y_mm=60.0,crown_mm=9.0,rim_mm=0.4}"
COATED = "design.coat={kind='opaque',color=[0.4,0.4,0.4]}"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["mini-magictac-finger", "--set", "design.face.crown_mm=9"],
         "face.crown_mm = 9 is not allowed: must be at most 3.96, 0.6 of the block's height of 6.6 mm"),
        (["mini-magictac-finger", "--set", "design.face.crown_mm=4.5"], "or the rim would cut the grid"),
        (["gelsight-type", "--set", TALL_DOME], "face.crown_mm = 9 is not allowed: must be at most"),
        (["gelsight-type-markers", "--set", "design.markers.margin_mm=20"],
         "markers lie outside of the face: diameter_mm + 2 * margin_mm = 40.6 must be at most 16"),
        (["gelsight-type-markers", "--set", "design.markers.depth_mm=20"],
         "markers.depth_mm = 20 is not allowed: must be below the height of"),
        (["see-through-markers", "--set", "rig.leds=[{place_mm=[0,0,1],direction=[0,0,-1],radiance=[1,1,1]}]"],
         "place_mm = [0.0, 0.0, 1.0] is not allowed: must be outside of the block"),
    ],
)  # fmt: skip
def test_what_a_sensor_cannot_have_is_one_line(shell: Shell, arguments: list[str], said: str):
    done = shell("plan", *arguments)
    assert done.code == 2
    assert said in done.err
    assert done.err.count("\n") == 1


def test_suite_of_see_through_detectors_refuses_a_coat():
    with pytest.raises(ConfigError, match=r"design.coat is opaque.*must be none or a half mirror"):
        load_suite("small", [COATED])


def test_grasp_task_refuses_a_coat():
    config = GraspConfig(scene=(COATED,))
    with pytest.raises(
        ConfigError, match=r"design = mini-magictac is not allowed with task grasp.*design.coat is opaque"
    ):
        task_scene(config, load_item("orange"))


def test_run_of_a_coated_sensor_says_that_proximity_is_not_judged(shell: Shell, tmp_path):
    small = [
        "design.footprint_mm=[8,8]", "rig.camera.columns=24", "rig.camera.rows=24", "rig.camera.field_mm=8",
        "references=3", "render.samples=1", "render.particles=1000", "render.anchor_samples=1", "output.preview=false",
        "keyframes=[{frame=0},{frame=1,gap_mm=2.0},{frame=2,flashlight=true}]",
    ]  # fmt: skip
    settings = [word for each in small for word in ("--set", each)]
    found = shell.json("simulate", "gelsight-type", "--out", tmp_path / "run", *settings)
    assert found["proximity_accuracy"] is None
    assert "proximity: design.coat is opaque, and nothing outside is seen" in found["not_judged"]
