import functools
from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.errors import ConfigError, FrameError
from magicsim.robot.digit import DigitCamera
from magicsim.robot.live import LiveSensor


@pytest.fixture
def digit(live: LiveSensor, monkeypatch: pytest.MonkeyPatch) -> DigitCamera:
    """A connected camera whose streams are ten times smaller, so that frames are cheap."""
    small = {
        "VGA": {"resolution": {"width": 64, "height": 48}, "fps": {"30fps": 30, "15fps": 15}},
        "QVGA": {"resolution": {"width": 32, "height": 24}, "fps": {"60fps": 60, "30fps": 30}},
    }
    monkeypatch.setattr(DigitCamera, "STREAMS", small)
    camera = DigitCamera("D12345", "left finger", sensor=live)
    camera.connect()
    return camera


def test_streams_are_the_documented_ones():
    small, large = DigitCamera.STREAMS["QVGA"], DigitCamera.STREAMS["VGA"]
    assert small == {"resolution": {"width": 320, "height": 240}, "fps": {"60fps": 60, "30fps": 30}}
    assert large == {"resolution": {"width": 640, "height": 480}, "fps": {"30fps": 30, "15fps": 15}}


@pytest.mark.slow
def test_first_frame_is_320_rows_by_240_columns(live: LiveSensor):
    camera = DigitCamera(sensor=live)
    camera.connect()
    assert camera.get_frame().shape == (320, 240, 3)
    assert camera.get_frame(transpose=True).shape == (240, 320, 3)


def test_frame_is_the_sensors_in_bgr_and_portrait(digit: DigitCamera, live: LiveSensor):
    live.move_to(gap_mm=0.5, x_mm=1.5, y_mm=1.0)
    moment = live.now()
    frame = digit.get_frame()
    assert frame.shape == (32, 24, 3)
    assert frame.dtype == np.uint8
    assert (frame[..., ::-1] == live.develop(moment).image).all()


def test_transposed_frame_is_turned_clockwise(digit: DigitCamera, live: LiveSensor):
    portrait = digit.get_frame()
    live.reset()
    landscape = digit.get_frame(transpose=True)
    assert (landscape == cv2.rotate(portrait, cv2.ROTATE_90_CLOCKWISE)).all()


def test_user_code_runs_with_the_sensor_bound_once(live: LiveSensor, digit: DigitCamera):
    Digit = functools.partial(DigitCamera, sensor=live)
    finger = Digit("D54321", "right finger")
    finger.connect()
    finger.set_resolution(DigitCamera.STREAMS["VGA"])
    finger.set_fps(DigitCamera.STREAMS["VGA"]["fps"]["15fps"])
    assert (finger.serial, finger.name, finger.fps) == ("D54321", "right finger", 15)
    assert finger.resolution == {"width": 64, "height": 48}
    assert finger.get_frame().shape == (64, 48, 3)
    assert "D54321" in finger.info()
    finger.disconnect()
    finger.disconnect()


def test_leds_follow_their_numbers(digit: DigitCamera):
    full = digit.get_frame().astype(float)
    assert digit.set_intensity_rgb(0, 15, 5) == (0, 15, 5)
    frame = digit.get_frame().astype(float)
    assert frame[..., 2].max() <= 1
    assert frame[..., 1].mean() == pytest.approx(full[..., 1].mean(), rel=0.01)
    assert frame[..., 0].mean() == pytest.approx(full[..., 0].mean() / 3, rel=0.02)
    assert digit.set_intensity(0) == 0
    assert digit.get_frame().max() <= 1
    assert digit.intensity == (0, 0, 0)


@pytest.mark.parametrize("strength", [-1, 16, 1.5])
def test_led_strength_outside_of_0_to_15_is_refused(digit: DigitCamera, strength: float):
    with pytest.raises(ConfigError, match=f"intensity_g = {strength} is not allowed: must be a whole number"):
        digit.set_intensity_rgb(0, strength, 0)
    assert digit.intensity == (15, 15, 15)


def test_difference_does_not_wrap(digit: DigitCamera):
    reference = digit.get_frame()
    assert np.abs(digit.get_diff(reference).astype(int)).max() <= 5
    digit.set_intensity(0)
    assert (digit.get_diff(reference).astype(int) >= reference.astype(int) - 1).all()
    with pytest.raises(FrameError, match="ref_frame is uint8"):
        digit.get_diff(reference[:-1])


def test_saved_frame_is_the_returned_one(digit: DigitCamera, tmp_path: Path):
    target = tmp_path / "frame.png"
    frame = digit.save_frame(str(target))
    assert (cv2.imread(str(target)) == frame).all()
    assert list(tmp_path.iterdir()) == [target]
    with pytest.raises(ConfigError, match="must end in"):
        digit.save_frame(tmp_path / "frame.xyz")


def test_other_streams_and_rates_are_refused(digit: DigitCamera):
    with pytest.raises(ConfigError, match=r"must be STREAMS\['VGA'\] or STREAMS\['QVGA'\]"):
        digit.set_resolution({"width": 100, "height": 100})
    with pytest.raises(ConfigError, match="fps = 15 is not allowed: must be 60 or 30 in the stream QVGA"):
        digit.set_fps(15)


def test_frames_need_a_connection(live: LiveSensor):
    camera = DigitCamera(sensor=live)
    with pytest.raises(ConfigError, match=r"DIGIT SIM00001 is not connected: call connect\(\) first"):
        camera.get_frame()
    with pytest.raises(ConfigError, match="not connected"):
        camera.set_intensity(3)


def test_view_shows_frames_and_differences_until_it_ends(digit: DigitCamera, monkeypatch: pytest.MonkeyPatch):
    shown: list[np.ndarray] = []

    class Screen:
        is_open = True

        def __init__(self, title: str) -> None:
            assert digit.serial in title

        def show(self, image: np.ndarray) -> None:
            shown.append(image)
            Screen.is_open = len(shown) < 3

        def close(self) -> None:
            shown.append(np.empty(0))

    monkeypatch.setattr("magicsim.robot.digit.Picture", Screen)
    reference = digit.get_frame()
    digit.show_view(frames=2)
    assert [each.shape for each in shown] == [(32, 24, 3), (32, 24, 3), (0,)]
    Screen.is_open = True
    digit.show_view(reference)
    assert shown[3].mean() < 0.2 * shown[0].mean()
    assert len(shown) == 5


def test_every_public_name_of_a_digit_is_there():
    names = (
        "connect", "disconnect", "get_diff", "get_frame", "info", "save_frame", "set_fps", "set_intensity",
        "set_intensity_rgb", "set_resolution", "show_view", "STREAMS", "LIGHTING_MIN", "LIGHTING_MAX", "dev_name",
        "manufacturer", "model", "revision", "resolution", "fps",
    )  # fmt: skip
    assert not [name for name in names if not hasattr(DigitCamera, name)]
