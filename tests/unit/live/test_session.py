"""Wishes carried out on a small sensor, and refused in one line."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.judge.recorded import read_episode
from magicsim.judge.verdicts import TABLE
from magicsim.live.recording import Recording
from magicsim.live.session import Session
from magicsim.robot.quality import FULL_QUALITY
from magicsim.scenes.scene import load_scene

from .conftest import SPACE


@pytest.fixture(scope="module")
def lines() -> list[str]:
    return []


@pytest.fixture(scope="module")
def session(tiny_scene, lines) -> Session:
    return Session(tiny_scene, quality=FULL_QUALITY, workspace=SPACE, told=lines.append)


def test_sensor_is_built_at_the_first_wish_and_says_what_it_does(session: Session, lines: list[str]):
    sight = session.look(session.go(replace(session.now, gap_mm=2.0)))
    assert [line for line in lines if "so far" not in line] == [
        "building the block and its lattice",
        "rendering the untouched sensor",
        "learning the untouched sensor",
    ]
    assert sight.frame is not None
    assert sight.frame.image.shape == (32, 24, 3)
    assert set(sight.verdicts) == {"calibrated", "published"}
    assert len(session.references) == 3
    assert all(frame.truth.is_reference for frame in session.references)
    assert sight.frames_per_second > 0


def test_pressing_moves_the_lattice_and_gives_a_force(session: Session):
    sight = session.go(replace(session.now, gap_mm=-0.4))
    assert sight.refusal is None
    assert sight.force_n[2] > 0
    assert sight.displacement_mm.max() > 0.1
    assert sight.object_pose is not None
    assert np.allclose(sight.nodes_mm, session.live.sensor.lattice.nodes_mm + session.live.deformation.displacements_mm)


def test_refused_pose_says_why_and_the_object_stays(session: Session):
    before = session.go(replace(session.now, gap_mm=-0.3)).wish
    sight = session.go(replace(session.now, x_mm=50.0))
    assert sight.refusal is not None
    assert sight.refusal.startswith("x_mm = 50 is not allowed")
    assert len(sight.refusal.splitlines()) == 1
    assert sight.wish == before == session.now


def test_design_that_cannot_be_built_leaves_the_sensor_as_it_was(session: Session):
    before = session.live
    sight = session.go(replace(session.now, design=(0.8, 5.0, 0.8, 0.0)))
    assert sight.refusal is not None
    assert "wall_mm" in sight.refusal
    assert session.live is before


def test_lights_and_exposure_change_the_frame(session: Session):
    plain = session.look(session.go(replace(session.now, gap_mm=5.0))).frame
    dim = session.look(session.go(replace(session.now, led_strength=(0.2, 1.0, 1.0)))).frame
    assert dim.image[..., 0].mean() < 0.4 * plain.image[..., 0].mean()
    session.go(replace(session.now, led_strength=(1.0, 1.0, 1.0)))
    bright = session.look(session.go(replace(session.now, exposure_grey=150.0))).frame
    assert bright.image.mean() > 1.3 * plain.image.mean()
    session.go(replace(session.now, exposure_grey=90.0))


def test_recording_is_an_episode_that_can_be_simulated_again(session: Session, tmp_path):
    recording = Recording(session.live.scene, session.references, session.live.sensor.printed, session.now)
    for gap in (2.0, 1.0):
        recording.add(session.look(session.go(replace(session.now, gap_mm=gap))).frame)
    recording.write(tmp_path / "take", estimator="fluence")
    assert {each.name for each in (tmp_path / "take").iterdir()} >= {TABLE, "frames", "config.toml", "report.html"}
    scene = load_scene(tmp_path / "take" / "config.toml")
    assert [keyframe.gap_mm for keyframe in scene.keyframes] == [2.0, 1.0]
    read = read_episode(tmp_path / "take")
    assert (len(read.references), len(read.frames)) == (3, 2)


def test_object_that_is_away_keeps_its_place(session: Session):
    sight = session.go(replace(session.now, has_object=False, gap_mm=3.0, x_mm=0.5))
    assert (sight.wish.has_object, sight.wish.gap_mm, sight.wish.x_mm) == (False, 3.0, 0.5)
    assert session.go(replace(sight.wish, has_object=True)).object_pose.position_mm[0] == 0.5


def test_object_that_a_scene_has_not_is_refused(tiny_scene, lines):
    bare = tiny_scene.model_copy(update={"object": None})
    session = Session(bare, quality=FULL_QUALITY, workspace=SPACE, told=lines.append)
    assert not session.now.has_object
    sight = session.go(replace(session.now, has_object=True))
    assert sight.refusal is not None
    assert sight.refusal.startswith("object is missing")


def test_object_waits_inside_of_the_workspace(tiny_scene, lines):
    space = replace(SPACE, x_mm=(1.0, 2.0), gap_mm=(-1.0, 3.0))
    session = Session(tiny_scene, quality=FULL_QUALITY, workspace=space, told=lines.append)
    assert (session.now.x_mm, session.now.gap_mm) == (1.0, 3.0)


def test_thin_block_is_pressed_no_deeper_than_it_allows(tiny_scene, lines):
    design = tiny_scene.design.model_copy(update={"core_mm": 0.9, "skin_mm": 0.4})
    thin = tiny_scene.model_copy(update={"design": design})
    session = Session(thin, quality=FULL_QUALITY, workspace=replace(SPACE, gap_mm=(-2, 10)), told=lines.append)
    assert session.go(session.now).refusal is None
    refusal = session.go(replace(session.now, gap_mm=-1.8)).refusal
    assert refusal is not None
    assert refusal.startswith("gap_mm = -1.8 is not allowed: must be -1.53 to 10")


def test_another_design_is_built_under_the_same_lights(session: Session):
    session.go(replace(session.now, led_strength=(0.5, 1.0, 1.0)))
    sight = session.go(replace(session.now, design=(1.0, 5.0, 0.8, 0.1)))
    assert sight.refusal is None
    assert session.live.now().led_strength == (0.5, 1.0, 1.0)
    assert session.scene.design.skin_mm == 1.0
    assert sight.wish.design[0] == 1.0
