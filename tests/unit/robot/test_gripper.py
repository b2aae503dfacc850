from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import SIDES, ObjectPlace, finger_pose
from magicsim.robot.grip.pair import BALANCE_N
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import LiveSensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene

from .conftest import BLOCK, TINY

SPACE = Workspace(x_mm=(-1, 1), y_mm=(-1, 1), twist_deg=(0, 0), gap_mm=(-1.2, 5))


def block(*more: str) -> SceneConfig:
    return load_scene("pressed", [*BLOCK, *more])


@pytest.fixture(scope="module")
def shared_gripper() -> Iterator[Gripper]:
    with Gripper(block(), workspace=SPACE) as gripper:
        yield gripper


@pytest.fixture
def gripper(shared_gripper: Gripper) -> Gripper:
    """Two fingers of a block without friction, open, that are solved and not rendered."""
    shared_gripper.reset()
    return shared_gripper


@pytest.fixture
def rubbing_gripper() -> Iterator[Gripper]:
    with Gripper(load_scene("grip", BLOCK), workspace=SPACE) as gripper:
        yield gripper


def test_symmetric_grasp_is_in_balance(gripper: Gripper):
    gripper.close(gripper.touching_width_mm - 1)
    truth = gripper.truth()
    assert truth.upper.depth_mm == pytest.approx(0.5)
    assert truth.lower.depth_mm == pytest.approx(0.5)
    assert truth.upper.force_n[2] > 0.5
    assert np.abs(truth.force_n).max() < 1e-6 * truth.upper.force_n[2]
    assert np.abs(truth.torque_nmm).max() < 1e-6 * truth.upper.force_n[2]


def test_object_off_the_middle_presses_the_nearer_finger_deeper(gripper: Gripper):
    gripper.close(gripper.touching_width_mm - 0.6, place=ObjectPlace(x_mm=0.5, z_mm=0.2))
    truth = gripper.truth()
    assert (truth.upper.depth_mm, truth.lower.depth_mm) == pytest.approx((0.5, 0.1))
    assert (truth.upper.state.x_mm, truth.lower.state.x_mm) == (0.5, -0.5)
    assert truth.force_n[2] == pytest.approx(truth.lower.force_n[2] - truth.upper.force_n[2])
    assert truth.imbalance_n == pytest.approx(-truth.force_n[2])


def test_torque_is_about_the_object(gripper: Gripper):
    gripper.close(gripper.touching_width_mm - 1, place=ObjectPlace(x_mm=0.7, y_mm=-0.4))
    truth = gripper.truth()
    # Without friction every force on a ball points to its centre.
    assert np.abs(truth.torque_nmm).max() < 1e-6 * truth.upper.force_n[2]


def test_floating_object_comes_to_the_middle_of_equal_fingers(gripper: Gripper):
    gripper.close(gripper.touching_width_mm - 0.6, place=ObjectPlace(z_mm=0.25), floats=True)
    assert gripper.place.z_mm == pytest.approx(0, abs=0.01)
    assert abs(gripper.truth().imbalance_n) <= BALANCE_N


def test_floating_object_is_pushed_by_the_finger_that_touches_it(gripper: Gripper):
    gripper.close(gripper.touching_width_mm + 0.4, place=ObjectPlace(z_mm=0.5), floats=True)
    assert gripper.place.z_mm == pytest.approx(0.2)
    assert not gripper.truth().upper.contact
    gripper.close(gripper.touching_width_mm + 0.4, place=ObjectPlace(z_mm=0.1), floats=True)
    assert gripper.place.z_mm == 0.1


@pytest.mark.slow
def test_floating_object_rests_where_unlike_fingers_press_alike():
    soft = block("design.materials.body.youngs_modulus_mpa=0.5")
    with Gripper(block(), workspace=SPACE, lower=soft) as gripper:
        gripper.close(gripper.touching_width_mm - 1, floats=True)
        truth = gripper.truth()
        assert gripper.place.z_mm < -0.05  # into the softer finger
        assert abs(truth.imbalance_n) <= BALANCE_N
        ball = parse_object("sphere:radius_mm=4")
        for design, side in ((block().design, truth.upper), (soft.design, truth.lower)):
            alone = press(design, ball, depth_mm=side.depth_mm)
            assert side.force_n[2] == pytest.approx(alone.force_n[2], rel=0.02)


def test_closing_too_far_leaves_both_fingers_where_they_were(gripper: Gripper):
    gripper.close(gripper.touching_width_mm + 1)
    before = gripper.upper.state, gripper.lower.state
    with pytest.raises(ConfigError, match=r"gap_mm = -1.5 is not allowed: must be -1.2 to 5"):
        gripper.close(gripper.touching_width_mm - 3)
    with pytest.raises(ConfigError, match="gap_mm"):
        gripper.close(gripper.touching_width_mm - 2.2, place=ObjectPlace(z_mm=-0.5))
    assert (gripper.upper.state, gripper.lower.state) == before
    assert gripper.width_mm == gripper.touching_width_mm + 1


def test_finger_that_fails_takes_the_other_back(gripper: Gripper, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        msg = "no equilibrium"
        raise ConvergenceError(msg)

    monkeypatch.setattr(gripper.lower.sensor, "deform", fail)
    with pytest.raises(ConvergenceError):
        gripper.close(gripper.touching_width_mm - 0.2)
    assert not gripper.truth().upper.contact


def test_scene_without_an_object_is_refused():
    with pytest.raises(ConfigError, match="object is missing"):
        Gripper(load_scene("rest"))


def test_released_gripper_is_closed():
    gripper = Gripper(block(), workspace=SPACE)
    gripper.release()
    gripper.release()
    with pytest.raises(ConfigError, match="closed"):
        gripper.frames()


@pytest.fixture(scope="module")
def seeing() -> Iterator[Gripper]:
    with Gripper(load_scene("pressed", TINY), workspace=SPACE) as gripper:
        yield gripper


def test_frames_come_in_pairs_of_one_moment_with_noise_of_their_own(seeing: Gripper):
    seeing.reset(seed=4)
    pair = seeing.frames()
    assert pair.upper.truth.index == pair.lower.truth.index == pair.truth.upper.index == 0
    assert pair.truth.lower == pair.lower.truth
    assert (pair.upper.image != pair.lower.image).any()
    seeing.reset(seed=4)
    again = seeing.frames()
    assert (again.upper.image == pair.upper.image).all()
    assert (again.lower.image == pair.lower.image).all()
    assert seeing.frames().upper.truth.index == 1


def test_each_finger_sees_the_other_behind_the_object(seeing: Gripper):
    seeing.reset(seed=4)
    seeing.close(seeing.touching_width_mm + 4)
    with_other = seeing.frames()
    for finger in (seeing.upper, seeing.lower):
        assert finger.state.facing_mm == seeing.width_mm
        finger.face(None)
    alone = seeing.frames()
    for one, other in ((with_other.upper, alone.upper), (with_other.lower, alone.lower)):
        assert one.image.mean() > other.image.mean() + 2


def test_fingers_open_as_far_from_an_object_whose_origin_is_not_its_middle():
    with Gripper(block("object={kind='banana',radius_mm=12}"), workspace=SPACE, sees_other=False) as opened:
        up, low = (finger.state.gap_mm for finger in opened.fingers)
        assert up == pytest.approx(low)
        assert up <= SPACE.gap_mm[1] + 1e-9


def test_lights_of_one_finger_are_not_told_from_the_others(seeing: Gripper):
    seeing.reset(seed=4)
    seeing.close(seeing.touching_width_mm + 4)
    seeing.upper.set_led_strength(0.5, 1, 1)
    with pytest.raises(ConfigError, match=r"LED strength = \(0\.5, 1\.0, 1\.0\) is not allowed before another finger"):
        seeing.frames()
    seeing.upper.set_led_strength(1, 1, 1)


def test_unlike_fingers_know_each_other(gripper: Gripper):
    assert gripper.upper.sensor.opposite is gripper.lower.sensor.opposite is None
    with Gripper(block(), workspace=SPACE, lower=block("design.materials.body.youngs_modulus_mpa=0.5")) as unlike:
        assert unlike.upper.sensor.opposite is unlike.lower.sensor
        assert unlike.lower.sensor.opposite is unlike.upper.sensor


@pytest.mark.slow
def test_unlike_fingers_see_each_others_light():
    scene = load_scene("pressed", TINY)
    strips = tuple(each.model_copy(update={"radiance": (5.0, 0.0, 0.0)}) for each in scene.rig.strips)
    red = scene.model_copy(update={"rig": scene.rig.model_copy(update={"strips": strips})})
    with Gripper(scene, workspace=SPACE, lower=red) as unlike, Gripper(scene, workspace=SPACE) as alike:
        added = []
        for gripper in (unlike, alike):
            upper = gripper.upper
            gripper.close(gripper.touching_width_mm + 4)
            both = upper.sensor.radiance(upper.state, upper.deformation).mean((0, 1))
            upper.face(None)
            added.append(both - upper.sensor.radiance(upper.state, upper.deformation).mean((0, 1)))
        unlike.lower.face(unlike.width_mm)
        lower = unlike.lower.sensor.radiance(unlike.lower.state, unlike.lower.deformation).mean((0, 1))
    assert added[0][0] > 1.5 * added[1][0]  # all of the other's strips are red
    assert (np.abs(added[0][1:]) < 0.2 * added[1][1:]).all()  # what is left of green and blue is sent back
    assert (lower[1:] > 0).all()  # the red finger has no green and blue but the other's


@pytest.mark.slow
def test_half_a_turn_about_y_swaps_the_images():
    more = ["render.samples=32", "render.particles=40000", "render.anchor_samples=64", "render.anchor_particles=40000"]
    with Gripper(load_scene("pressed", [*TINY, *more]), workspace=SPACE) as seeing:
        width = seeing.touching_width_mm - 1
        seeing.close(width, place=ObjectPlace(x_mm=1))
        right = seeing.frames()
        seeing.reset()  # A path through the other grasp would end only as near as solves are exact.
        seeing.close(width, place=ObjectPlace(x_mm=-1))
        left = seeing.frames()
    assert (right.upper.contact_mask == left.lower.contact_mask).all()
    assert (right.lower.contact_mask == left.upper.contact_mask).all()
    assert (right.upper.contact_mask == right.lower.contact_mask[:, ::-1]).all()  # what touches is mirrored
    columns = np.nonzero(right.upper.contact_mask)[1]
    assert columns.mean() > 12  # the gripper's +x is on the right of the upper image
    swapped = difference(right.upper.image, left.lower.image), difference(right.lower.image, left.upper.image)
    same_frame = difference(right.upper.image, right.lower.image)
    mirrored = difference(right.upper.image, right.lower.image[:, ::-1])  # red and blue would change sides
    assert max(swapped) < 0.35 * min(same_frame, mirrored)


def difference(first: np.ndarray, second: np.ndarray) -> float:
    """Root mean square over pixels and channels, in grey levels."""
    return float(np.sqrt(((first.astype(float) - second) ** 2).mean()))


def test_seeds_of_the_fingers_differ_from_seed_to_seed_and_finger_to_finger(gripper: Gripper):
    seeds = []
    for seed in (0, 1):
        gripper.reset(seed=seed)
        seeds += [finger.now().seed for finger in gripper.fingers]
    assert len(set(seeds)) == 4


def test_workspace_of_the_lower_finger_is_turned(gripper: Gripper):
    space = replace(SPACE, x_mm=(-0.5, 1), twist_deg=(-10, 40))
    with Gripper(block(), workspace=space) as turned:
        lower: LiveSensor = turned.lower
        assert lower.workspace.x_mm == (-1, 0.5)
        assert lower.workspace.twist_deg == (-40, 10)
        turned.close(turned.touching_width_mm + 1, place=ObjectPlace(x_mm=1, twist_deg=40))
        assert lower.state.x_mm == -1


def test_motion_of_both_fingers_is_one_wait(
    gripper: Gripper, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("magicsim.waiting.FIRST_S", 0.0)
    monkeypatch.setattr("magicsim.waiting.NEXT_S", 0.001)
    gripper.close(gripper.touching_width_mm - 1, floats=True)
    lines = capsys.readouterr().err.splitlines()
    assert lines
    assert all(line.startswith("magicsim: moving the fingers") for line in lines)
    assert any(": solving the contact, " in line for line in lines)


def test_what_nobody_sees_or_was_not_given_is_refused(gripper: Gripper):
    shape = parse_object("sphere:radius_mm=1").surface()
    with pytest.raises(ConfigError, match="companion is not allowed with sees_other = False"):
        Gripper(block(), workspace=SPACE, companion=shape, sees_other=False)
    assert not gripper.has_companion
    with pytest.raises(ConfigError, match="companion is missing: build the sensor with what is to be seen"):
        gripper.accompany(Pose.from_degrees(np.zeros(3)))
    gripper.accompany(None)


def test_motion_beyond_what_the_print_bears_is_told_once_or_refused(caplog: pytest.LogCaptureFixture):
    limited = "design.limits.force_n=0.5"
    with (
        Gripper(block(limited), workspace=SPACE) as warning,
        Gripper(block(limited), workspace=SPACE, within_limits=True) as strict,
    ):
        narrow, wide = warning.touching_width_mm - 1, warning.touching_width_mm - 0.1
        for width in (wide, narrow, narrow - 0.2):
            warning.close(width)
        assert warning.truth().beyond_limits
        messages = [record.message for record in caplog.records]
        assert len(messages) == 2  # one for each finger
        assert all("N is above design.limits.force_n = 0.5" in each for each in messages)
        strict.close(wide)
        with pytest.raises(ConfigError, match=r"not allowed with within_limits: .* above design.limits.force_n = 0.5"):
            strict.close(narrow)
        assert strict.width_mm == wide
        assert not strict.truth().beyond_limits


def test_curved_fingers_press_an_object_beside_the_crown_where_it_is():
    radius, ball = 20.0, 4.0
    dome = f'design.face={{kind="dome",radius_x_mm={radius},radius_y_mm={radius},crown_mm=1.5}}'
    place, aside = ObjectPlace(x_mm=0.8, y_mm=-0.9), np.hypot(0.8, 0.9)
    with Gripper(block(dome), workspace=SPACE) as gripper:
        assert gripper.touching_width_mm == pytest.approx(2 * ball)
        # Both balls touch where their centres are both radii apart.
        deepest = np.sqrt((radius + ball) ** 2 - aside**2) - radius
        width = 2 * deepest - 0.6
        gripper.close(width, place=place)
        truth = gripper.truth()
        assert (truth.upper.depth_mm, truth.lower.depth_mm) == pytest.approx((0.3, 0.3), abs=1e-3)
        for side, finger in zip(SIDES, gripper.fingers, strict=True):
            origin = finger.sensor.indenter(finger.state).pose.position_mm
            assert finger_pose(side, width).to_sensor(origin[None])[0] == pytest.approx([0.8, -0.9, 0.0])


def test_skin_that_a_placed_object_drags_along_slides(rubbing_gripper: Gripper):
    gripper = rubbing_gripper
    gripper.close(gripper.touching_width_mm - 1)
    gripper.close(gripper.touching_width_mm - 1, place=ObjectPlace(x_mm=1.0))
    assert gripper.truth().slid_mm == max(finger.slid_mm for finger in gripper.fingers) > 0.1
    gripper.close(gripper.touching_width_mm + 1)
    assert gripper.truth().slid_mm == 0
