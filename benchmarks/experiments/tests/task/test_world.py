from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from magicsim.detectors.grasp import GraspStage
from magicsim.geometry.objects.kinds import parse_object
from magicsim.robot.grip.load import Hold
from magicsim.robot.gripper import Gripper
from magicsim.scenes.scene import load_scene
from magicsim_experiments.task.episode import command
from magicsim_experiments.task.settings import GraspConfig, Item
from magicsim_experiments.task.story import Flashlight, Since, draw_story
from magicsim_experiments.task.world import BEYOND_MM, SLIDE_MM, World, build_gripper

BLOCK = (
    "design=uniform-block", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32", "contact.friction=0.8",
)  # fmt: skip
BALL = parse_object("sphere:radius_mm=4")
ITEM = Item(schema_version=1, object=BALL, mass_g=20.0, friction=0.8, crush_n=10.0)
CONFIG = GraspConfig(
    grip_n=1.0,
    open_gap_mm=2.0,
    close_mm_s=8,
    distance_mm=40.0,
    pull_n_s=60.0,
    near_mm=(1.0, 1.0),
    hand_mm_s=(900, 900),
)
STORY = replace(
    draw_story(CONFIG, 0), appears=1, near_mm=1.0, y_mm=0.5, twist_deg=0.0, lights=(), pull=None,
)  # fmt: skip


@pytest.fixture(scope="module")
def gripper() -> Iterator[Gripper]:
    """Two blocks that are solved and not rendered."""
    scene = load_scene("grip", BLOCK).model_copy(update={"object": BALL})
    with build_gripper(scene, CONFIG) as gripper:
        yield gripper


def events(world: World, stages: list[GraspStage]) -> list[str]:
    return [world.step(stage, command(stage, is_open=world.is_open)).event for stage in stages]


def gripped(gripper: Gripper, **story: object) -> World:
    """A world in which the fingers have closed on the offered ball until their motors stalled."""
    gripper.reset()
    world = World(gripper, ITEM, replace(STORY, **story), CONFIG)
    assert events(world, [GraspStage.WAITING] * 3) == ["", "appears", "offered"]
    assert gripper.upper.state.gap_mm == pytest.approx(1.0)
    events(world, [GraspStage.CLOSING] * 15)
    assert gripper.truth().is_stalled
    assert gripper.truth().upper.force_n[2] == pytest.approx(1.0, rel=0.25)
    return world


def test_item_is_offered_gripped_carried_and_delivered(gripper: Gripper):
    world = gripped(gripper)
    stalled = gripper.width_mm
    told = events(world, [GraspStage.TRANSPORTING] * 12)
    assert told[0] == "let_go"
    assert set(told[1:]) == {""}
    assert world.is_held
    assert world.is_at_b
    assert gripper.width_mm == stalled
    assert gripper.truth().force_n[1] == pytest.approx(0.02 * 9.80665, rel=0.2)
    assert world.deliver() == "delivered"
    events(world, [GraspStage.RETURNING] * 14)
    assert not world.has_item
    assert world.is_open
    assert world.carriage.place_mm == 0


def test_pull_takes_the_item_out_of_the_fingers(gripper: Gripper):
    world = gripped(gripper, pull=1, pull_deg=0.0)
    told = events(world, [GraspStage.TRANSPORTING] * 6)
    assert told[0] == "let_go"
    assert "pulled" in told[1:]
    assert not world.has_item


def test_hand_comes_with_the_item_leaves_when_it_lets_go_and_comes_back_to_pull(gripper: Gripper):
    world = gripped(gripper, pull=6, pull_deg=0.0)
    fingers = gripper.fingers
    assert world.hand_mm == 0
    away = []
    for _ in range(9):
        world.step(GraspStage.TRANSPORTING, command(GraspStage.TRANSPORTING, is_open=False))
        away.append(world.hand_mm)
        poses = [each.state.companion for each in fingers]
        assert [pose is None for pose in poses] == [away[-1] is None] * 2
        if away[-1] is not None:
            upper, lower = (np.array(pose[:3]) for pose in poses if pose is not None)
            place = gripper.place
            shift = np.array([0.0, 0.0, gripper.width_mm / 2])
            np.testing.assert_allclose(upper + shift, [place.x_mm, place.y_mm + away[-1], place.z_mm], atol=1e-9)
            np.testing.assert_allclose(lower + shift, [-place.x_mm, place.y_mm + away[-1], -place.z_mm], atol=1e-9)
    assert away[:6] == pytest.approx([0, 60, 120, None, 120, 60])
    assert away[-1] is None  # gone with the item
    assert gripper.outcome is Hold.DROPPED


def test_hand_that_is_switched_off_is_not_shown(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, STORY, CONFIG.model_copy(update={"hand": False}))
    events(world, [GraspStage.WAITING] * 3)
    assert world.hand_mm == 0
    assert gripper.upper.state.companion is None


def test_flashlights_follow_what_happens(gripper: Gripper):
    gripper.reset()
    begins = {
        Since.BEGINNING: 0, Since.OFFERED: 1, Since.CLOSING: 4, Since.TRANSPORT: 1, Since.PULL: 1, Since.DELIVERED: 0,
    }  # fmt: skip
    lights = tuple(Flashlight(since=since, begin=begin, frames=1, x_mm=25.0) for since, begin in begins.items())
    late = Flashlight(since=Since.TRANSPORT, begin=4, frames=2, x_mm=25.0)  # after its end
    world = World(gripper, ITEM, replace(STORY, lights=(*lights, late), pull=2, pull_deg=0.0), CONFIG)
    stages = [GraspStage.WAITING] * 3 + [GraspStage.CLOSING] * 15 + [GraspStage.TRANSPORTING] * 4
    told = [
        world.step(stage, command(stage, is_open=world.is_open)).light
        for stage in [*stages, GraspStage.SLIPPED, GraspStage.RETURNING]
    ]
    # Offered in frame 2, closing from 3 on, transport from 18, pulled from 20 on; nothing is delivered.
    assert [frame for frame, is_lit in enumerate(told) if is_lit] == [0, 3, 7, 19, 21]
    assert not gripper.upper.state.flashlight


def test_item_that_nobody_takes_is_withdrawn(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, STORY, CONFIG)
    told = events(world, [GraspStage.WAITING] * 52)
    assert told.count("withdrawn") == 1
    assert not world.has_item


def test_empty_fingers_close_on_nothing_and_open_again(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, replace(STORY, appears=99), CONFIG)
    events(world, [GraspStage.CLOSING] * 5)
    assert gripper.width_mm < world.open_mm
    events(world, [GraspStage.RETURNING] * 5)
    assert world.is_open


def test_hand_begins_in_front_of_the_fingertips(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, replace(STORY, speed_mm_s=60.0), CONFIG)
    events(world, [GraspStage.WAITING] * 2)
    linkage = gripper.linkage
    ahead = linkage.along_mm(linkage.angle_deg(gripper.touching_width_mm)) - linkage.along_mm(gripper.angle_deg)
    assert gripper.place.y_mm == pytest.approx(STORY.y_mm + ahead + BEYOND_MM)


@pytest.mark.parametrize("near_mm", [1.0, 1.37, 45.0])
def test_wide_open_fingers_still_meet_the_item_where_it_was_offered(gripper: Gripper, near_mm: float):
    """An arc of several millimetres, more than the workspace has to the side, lies between open and closed.

    The finger that comes first pushes the item along without pressing it, far to the side of where it is fine.
    """
    gripper.reset()
    wide = CONFIG.model_copy(update={"open_gap_mm": 24.0, "close_mm_s": 30.0})
    world = World(gripper, ITEM, replace(STORY, near_mm=near_mm, y_mm=1.9), wide)
    linkage = gripper.linkage
    touching = linkage.along_mm(linkage.angle_deg(gripper.touching_width_mm))
    assert touching - linkage.along_mm(gripper.angle_deg) > SLIDE_MM
    events(world, [GraspStage.WAITING] * 4)
    events(world, [GraspStage.CLOSING] * 40)
    assert gripper.truth().is_stalled
    assert gripper.place.y_mm == pytest.approx(1.9, abs=0.05)


def test_hand_takes_back_an_item_that_finds_the_fingers_closed(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, replace(STORY, speed_mm_s=5.0), CONFIG)
    told = events(world, [GraspStage.WAITING] * 2 + [GraspStage.CLOSING] * 30)
    assert [each for each in told if each] == ["appears", "withdrawn"]
    assert not world.has_item


def test_hand_waits_until_the_fingers_are_open(gripper: Gripper):
    gripper.reset()
    world = World(gripper, ITEM, replace(STORY, appears=20), CONFIG)
    told = events(world, [GraspStage.CLOSING] * 25 + [GraspStage.RETURNING] * 20)
    assert told.index("appears") > 25


@pytest.mark.parametrize("near_mm", [0.01, 3.99])
@pytest.mark.parametrize("speed_mm_s", [1.0, 1000.0])
@pytest.mark.parametrize("rate", [1.0, 120.0])
def test_coarse_and_fast_motions_end_in_a_grip_or_without_the_item(
    gripper: Gripper, near_mm: float, speed_mm_s: float, rate: float
):
    gripper.reset()
    changed = {"frames_per_second": rate, "close_mm_s": speed_mm_s, "hand_mm_s": (speed_mm_s, speed_mm_s)}
    config = CONFIG.model_copy(update=changed)
    world = World(gripper, ITEM, replace(STORY, near_mm=near_mm, speed_mm_s=speed_mm_s), config)
    told = events(world, [GraspStage.WAITING] * 3 + [GraspStage.CLOSING] * 40)
    assert told[1] == "appears"
    assert gripper.truth().upper.force_n[2] < 1.3
    assert gripper.truth().is_stalled or "offered" not in told or speed_mm_s < 2
