"""What a face, a coat, markers or an LED cannot be is one line with the field and what is allowed."""

from typing import Any

import pytest

from magicsim.errors import ConfigError
from magicsim.evaluation.suite import load_suite
from magicsim.judge.measures import COMPUTE, TABLE
from magicsim.judge.verdicts import COATED

from .conftest import Shell

TALL_DOME = "design.face={kind='dome',radius_x_mm=40.0,radius_y_mm=60.0,crown_mm=9.0,rim_mm=0.4}"
COAT = "design.coat={kind='opaque',color=[0.4,0.4,0.4]}"


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
        (["gelsight-type", "--set", "design.coat.thickness_mm=0.05"],
         "design.coat: modulus_mpa is missing: a coat with thickness_mm needs both, one without stiffness neither"),
        (["gelsight-type", "--set", "design.coat.thickness_mm=0.4", "--set", "design.coat.modulus_mpa=1"],
         "coat.thickness_mm = 0.4 is not allowed: must be at most 0.3, 0.1 of the block's height of 3 mm"),
        (["gelsight-type", "--set", "design.coat.thickness_mm=0.05", "--set", "design.coat.modulus_mpa=90"],
         "coat.modulus_mpa = 90 is not allowed with coat.thickness_mm = 0.05: bending, which is left out, would count "
         "over 0.29 mm"),
        (["gelsight-type", "--set", "design.coat.thickness_mm=0.6", "--set", "design.coat.modulus_mpa=1"],
         "design.coat.thickness_mm = 0.6 is not allowed: must be a number of at least 0.001 and at most 0.5"),
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
        load_suite("small", [COAT])


SMALL = [
    "design.footprint_mm=[8,8]", "rig.camera.columns=24", "rig.camera.rows=24", "rig.camera.field_mm=8",
    "references=30", "render.samples=1", "render.particles=1000", "render.anchor_samples=1", "output.preview=false",
    "output.report=false", "keyframes=[{frame=0},{frame=1,gap_mm=2.0},{frame=2,flashlight=true},{frame=3,gap_mm=-0.4}]",
]  # fmt: skip


def small_run(shell: Shell, scene: str, *more: str) -> dict[str, Any]:
    settings = [word for each in (*SMALL, *more) for word in ("--set", each)]
    return shell.json("simulate", scene, "--out", "run", *settings)


def test_proximity_of_a_coated_run_is_not_judged_by_any_command(shell: Shell):
    found = small_run(shell, "gelsight-type")
    assert found["proximity_accuracy"] is None
    assert COATED in found["not_judged"]

    read = shell.json("detect", "run", "--profile", "published")
    assert read["not_judged"] == COATED
    assert [row["proximity"] for row in read["frames"]] == [None] * 4
    assert [row["combined"] for row in read["frames"]] == [row["contact"] for row in read["frames"]]
    told = shell("detect", "run", "--profile", "published").out
    assert told.endswith(f"not judged: {COATED}\n")
    assert "Approaching" not in told
    assert "Noise" not in told

    judged = shell.json("evaluate", "--on", "run", "--profile", "published", code=1)  # a class is never named
    headline = judged["metrics"][judged["standard"]]
    assert judged["not_judged"] == COATED
    assert {headline[name]["value"] for name in COMPUTE if TABLE[name].task == "proximity"} == {None}
    assert headline["contact_balanced_accuracy"]["value"] is not None
    assert not any(sum(row.values()) for row in judged["confusion"]["proximity"].values())
    assert judged["roc"]["approach"] is None
    assert f"not judged: {COATED}" in shell("evaluate", "--on", "run", "--profile", "published").out


def test_run_of_a_half_mirror_is_judged_whole(shell: Shell):
    small_run(shell, "see-through-markers")
    assert "not_judged" not in shell.json("detect", "run", "--profile", "published")
    judged = shell.json("evaluate", "--on", "run", "--profile", "published", code=1)  # a class is never named
    assert judged["not_judged"] is None
    assert sum(sum(row.values()) for row in judged["confusion"]["proximity"].values()) == 3
