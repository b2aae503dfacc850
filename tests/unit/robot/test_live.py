import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from magicsim.errors import ConfigError, ConvergenceError
from magicsim.robot.live import LiveSensor, live_sensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import load_scene
from magicsim.simulation.stream import simulate

from .conftest import BLOCK, TINY


@pytest.mark.parametrize(
    "settings",
    [pytest.param([], marks=pytest.mark.slow), ["rig.camera.region_px=[8,4,12,20]", "output.depth_map=true"]],
)
def test_frames_are_those_of_the_simulated_scene(settings: list[str]):
    tiny_scene = load_scene("pressed", [*TINY, *settings])
    episode = simulate(tiny_scene)
    here = Workspace(x_mm=(0, 0), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(-1, 30))
    with LiveSensor(tiny_scene, workspace=here) as live:
        frames = [live.frame(), live.frame()]
        live.move_to(gap_mm=-1.0)
        frames.append(live.frame())
    for ours, theirs in zip(frames, episode.frames, strict=True):
        assert (ours.image == theirs.image).all()
        assert replace(ours.truth, is_reference=theirs.truth.is_reference, frame_class=None) == replace(
            theirs.truth, frame_class=None
        )
        assert (ours.contact_mask == theirs.contact_mask).all()
        assert (ours.displacements_mm == theirs.displacements_mm).all()
        assert (ours.labels.depth_map_mm is None) == (theirs.labels.depth_map_mm is None) == (not settings)
        if settings:
            assert (ours.depth_map_mm == theirs.depth_map_mm).all()
            assert ours.image.shape == (20, 12, 3)


def test_led_strength_scales_the_strips_and_not_the_room():
    live = live_sensor(
        "pressed", [*TINY, "rig.room='office'", "rig.ambient=[0.5,0.5,0.5]", "rig.camera.exposure_grey=50"]
    )
    means = []
    for strength in (0.0, 1.0, 2.0):
        live.set_led_strength(strength, strength, strength)
        means.append(live.frame().image.mean((0, 1)))
    assert (means[0] > 2).all()
    np.testing.assert_allclose(means[2] - means[1], means[1] - means[0], atol=1)
    assert (means[1] - means[0] > 10).all()


def test_a_coded_video_is_refused():
    scene = load_scene("pressed", [*TINY, "rig.camera.compression={kind='h264'}"])
    with pytest.raises(ConfigError, match=r"compression\.kind = 'h264' is not allowed here") as error:
        LiveSensor(scene)
    assert len(str(error.value).splitlines()) == 1


def test_equal_states_are_rendered_once_with_noise_of_their_own(live: LiveSensor, monkeypatch: pytest.MonkeyPatch):
    live.frame()  # meters the untouched sensor
    rendered = []
    original = live.sensor.render
    monkeypatch.setattr(live.sensor, "render", lambda *state: rendered.append(state) or original(*state))
    live.move_to(gap_mm=7.25)
    first, second = live.frame(), live.frame()
    assert len(rendered) == 1
    assert (first.image != second.image).any()
    assert np.abs(first.image.astype(int) - second.image).mean() < 1
    assert (second.truth.index, second.truth.time_s) == (2, pytest.approx(2 / 15))


def test_stream_repeats_from_its_seed(live: LiveSensor):
    def stream(seed: int | None) -> list[np.ndarray]:
        live.reset(seed=seed)
        live.move_to(gap_mm=3.0)
        return [live.frame().image, live.frame().image]

    assert all((a == b).all() for a, b in zip(stream(5), stream(5), strict=True))
    assert (stream(5)[0] != stream(6)[0]).any()
    assert (stream(None)[0] == stream(live.sensor.seed)[0]).all()


def test_object_at_plus_x_and_plus_y_is_right_and_up_in_the_image(live: LiveSensor):
    live.move_to(gap_mm=-0.4, x_mm=1.5, y_mm=1.0)
    rows, columns = np.nonzero(live.frame().contact_mask)
    assert columns.mean() > 12 + 2  # 24 columns over 10 mm
    assert rows.mean() < 16 - 1


@pytest.mark.slow
def test_motion_in_any_order_ends_where_a_direct_one_does(live: LiveSensor):
    for x, y, gap in [(1, 1, -0.6), (-2, -3, 0.5), (0, 0, -0.8), (-1, -1, -0.4)]:
        live.move_to(gap_mm=gap, x_mm=x, y_mm=y)
    wandered = live.truth
    live.remove_object()
    assert live.truth.force_n == (0, 0, 0)
    live.move_to(gap_mm=-0.4, x_mm=-1, y_mm=-1)
    assert wandered.force_n == pytest.approx(live.truth.force_n, abs=0.02 * live.truth.force_n[2])


@pytest.mark.slow
def test_friction_remembers_the_way(rubbing: LiveSensor):
    rubbing.move_to(gap_mm=-0.8, y_mm=-0.5)
    straight = np.array(rubbing.truth.force_n)
    rubbing.remove_object()
    rubbing.move_to(gap_mm=-0.8)
    rubbing.move_to(y_mm=-0.5)
    dragged = np.array(rubbing.truth.force_n)
    rubbing.remove_object()
    rubbing.move_to(gap_mm=0.0, y_mm=0.0)
    rubbing.move_to(gap_mm=-0.8, y_mm=-0.5)
    oblique = np.array(rubbing.truth.force_n)
    assert abs(straight[1]) < 0.02 * straight[2]
    assert dragged[1] < oblique[1] < -0.1 * oblique[2]


@pytest.mark.slow
def test_long_slide_ends_at_the_limit_of_friction(rubbing: LiveSensor):
    rubbing.move_to(gap_mm=-0.4, y_mm=1.0)
    rubbing.move_to(y_mm=-2.0)
    force = rubbing.truth.force_n
    assert rubbing.slip_share > 0.99
    assert -force[1] / force[2] == pytest.approx(0.8, rel=0.15)  # the ball's face is not level
    assert 1.5 < rubbing.slid_mm < 3  # 3 mm less what the skin follows


def test_motion_that_fails_leaves_everything_as_it_was(rubbing: LiveSensor, monkeypatch: pytest.MonkeyPatch):
    rubbing.move_to(gap_mm=-0.3)
    before, state = rubbing.deformation, rubbing.state

    def fail(*_: object) -> None:
        msg = "no equilibrium"
        raise ConvergenceError(msg)

    monkeypatch.setattr(rubbing.sensor, "deform", fail)
    with pytest.raises(ConvergenceError):
        rubbing.move_to(gap_mm=-0.5)
    with pytest.raises(ConfigError, match="x_mm = 50 is not allowed"):
        rubbing.move_to(x_mm=50)
    assert rubbing.deformation is before
    assert rubbing.state == state


def test_going_back_restores_pose_history_and_light(rubbing: LiveSensor):
    rubbing.move_to(gap_mm=-0.3)
    moment = rubbing.now()
    rubbing.move_to(y_mm=-0.3)
    first = rubbing.truth.force_n
    rubbing.set_led_strength(0, 0, 0)
    rubbing.go_back(moment)
    assert rubbing.now() == moment
    rubbing.move_to(y_mm=-0.3)
    assert rubbing.truth.force_n == first


def test_led_strengths_scale_their_channels_and_not_the_flashlight(live: LiveSensor):
    full = live.frame().image.astype(float)
    live.set_led_strength(0.5, 0.0, 1.0)
    dimmed = live.frame().image.astype(float)
    assert dimmed[..., 0].mean() == pytest.approx(full[..., 0].mean() / 2, rel=0.01)
    assert dimmed[..., 1].max() <= 1
    assert dimmed[..., 2].mean() == pytest.approx(full[..., 2].mean(), rel=0.01)
    live.shine()
    live.set_led_strength(1, 1, 1)
    lit = live.frame().image.astype(float)
    live.set_led_strength(0, 0, 0)
    outside = live.frame().image.astype(float)
    unclipped = lit < 255
    assert (outside[unclipped] + full[unclipped]).mean() == pytest.approx(lit[unclipped].mean(), rel=0.03)
    live.shine(on=False)
    assert live.frame().image.max() <= 1


@pytest.mark.parametrize("strength", [(-0.1, 1, 1), (1, float("nan"), 1)])
def test_impossible_led_strength_is_refused(live: LiveSensor, strength: tuple[float, float, float]):
    with pytest.raises(ConfigError, match="LED strength"):
        live.set_led_strength(*strength)


@pytest.mark.slow
def test_image_size_changes_the_picture_and_not_the_contact(live: LiveSensor):
    live.move_to(gap_mm=-1.0)
    small, deformation = live.frame(), live.deformation
    live.set_image_size(columns=48, rows=64)
    large = live.frame()
    assert large.image.shape == (64, 48, 3)
    assert live.deformation is deformation
    assert large.contact_mask.mean() == pytest.approx(small.contact_mask.mean(), rel=0.1)
    with pytest.raises(ConfigError, match=r"columns = 4 is not allowed"):
        live.set_image_size(columns=4, rows=64)


@pytest.mark.parametrize("rate", [0, -1, 1001, float("nan")])
def test_impossible_frame_rate_is_refused(rubbing: LiveSensor, rate: float):
    with pytest.raises(ConfigError, match="frames_per_second"):
        rubbing.set_frame_rate(rate)


@pytest.mark.parametrize("seed", [-1, 2**31])
def test_impossible_seed_is_refused(rubbing: LiveSensor, seed: int):
    with pytest.raises(ConfigError, match="seed"):
        rubbing.reset(seed=seed)


def test_first_motion_must_say_how_far_the_object_is(rubbing: LiveSensor):
    with pytest.raises(ConfigError, match="gap_mm is missing"):
        rubbing.move_to(x_mm=1.0)


def test_scene_without_an_object_has_nothing_to_move():
    with LiveSensor(load_scene("rest", TINY[:-1])) as live, pytest.raises(ConfigError, match="object is missing"):
        live.move_to(gap_mm=1.0)


def test_scene_that_depends_on_time_is_refused():
    with pytest.raises(ConfigError, match=r"contact\.rate_dependent = True is not allowed"):
        live_sensor("grip", [*BLOCK, "contact.rate_dependent=true"])


def test_closed_sensor_lets_go_of_its_renderer_and_says_that_it_is_closed():
    live = live_sensor("grip", BLOCK)
    renderer = weakref.ref(live.sensor.renderer)
    with live:
        pass
    gc.collect()
    assert renderer() is None
    assert live.is_closed
    live.close()
    with pytest.raises(ConfigError, match="the sensor is closed"):
        live.frame()
