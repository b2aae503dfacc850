from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.robot.capture import SimulatedCapture
from magicsim.robot.live import LiveSensor


def test_it_has_every_method_that_camera_code_calls():
    used = {"read", "isOpened", "get", "set", "release", "grab", "retrieve", "open", "getBackendName"}
    assert used <= set(dir(cv2.VideoCapture)) & set(dir(SimulatedCapture))


def test_read_gives_the_sensors_frame_in_bgr(live: LiveSensor):
    capture = SimulatedCapture(live)
    is_read, frame = capture.read()
    live.reset()
    assert is_read
    assert frame.dtype == np.uint8
    assert (frame[..., ::-1] == live.frame().image).all()


def test_red_light_is_in_the_last_channel_as_opencv_has_it(live: LiveSensor):
    live.set_led_strength(1, 0, 0)
    frame = SimulatedCapture(live).read()[1]
    assert frame[..., 2].mean() > 50
    assert frame[..., :2].max() <= 1


def test_a_real_capture_of_the_written_frames_answers_alike(live: LiveSensor, tmp_path: Path):
    simulated = SimulatedCapture(live)
    frames = [simulated.read()[1] for _ in range(3)]
    for number, frame in enumerate(frames):
        cv2.imwrite(str(tmp_path / f"{number:02d}.png"), frame)
    real = cv2.VideoCapture(str(tmp_path / "%02d.png"))
    for property_number in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT):
        assert simulated.get(property_number) == real.get(property_number)
    for frame in frames:
        is_read, read = real.read()
        assert type(is_read) is bool
        assert (read == frame).all()
    real.release()
    simulated.release()
    assert simulated.isOpened() == real.isOpened() == False  # noqa: E712
    assert simulated.read() == real.read() == (False, None)
    assert simulated.grab() == real.grab()
    assert simulated.retrieve() == real.retrieve()
    assert simulated.get(cv2.CAP_PROP_FRAME_WIDTH) == real.get(cv2.CAP_PROP_FRAME_WIDTH)
    assert simulated.set(cv2.CAP_PROP_FPS, 30) == real.set(cv2.CAP_PROP_FPS, 30)


def test_frame_is_that_of_the_moment_it_was_grabbed(live: LiveSensor):
    capture = SimulatedCapture(live)
    assert capture.retrieve() == (False, None)
    assert capture.grab()
    live.set_led_strength(0, 0, 0)
    grabbed = capture.retrieve()[1]
    assert grabbed.mean() > 50
    assert (capture.retrieve()[1] == grabbed).all()
    assert capture.read()[1].max() <= 1


def test_world_is_moved_before_every_frame_at_its_time(live: LiveSensor):
    seen = []

    def world(sensor: LiveSensor, time_s: float) -> None:
        seen.append(time_s)
        sensor.set_led_strength(*[1.0 if len(seen) == 1 else 0.0] * 3)

    live.set_frame_rate(10)
    capture = SimulatedCapture(live, world=world)
    means = [capture.read()[1].mean() for _ in range(2)]
    assert seen == [0.0, pytest.approx(0.1)]
    assert means[0] > 50 > means[1]


def test_properties_are_those_of_the_sensor_and_can_be_set(live: LiveSensor):
    capture = SimulatedCapture(live)
    assert capture.get(cv2.CAP_PROP_FRAME_WIDTH) == 24
    assert capture.get(cv2.CAP_PROP_FRAME_HEIGHT) == 32
    assert capture.set(cv2.CAP_PROP_FPS, 30)
    assert capture.get(cv2.CAP_PROP_FPS) == 30
    assert capture.grab()
    assert capture.get(cv2.CAP_PROP_POS_FRAMES) == 1
    assert capture.get(cv2.CAP_PROP_POS_MSEC) == pytest.approx(1000 / 30)
    assert capture.set(cv2.CAP_PROP_FRAME_WIDTH, 12)
    assert capture.set(cv2.CAP_PROP_FRAME_HEIGHT, 16)
    assert capture.read()[1].shape == (16, 12, 3)
    assert capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
    capture.grab()
    bgr_switched_off = capture.retrieve()[1]
    assert capture.set(cv2.CAP_PROP_CONVERT_RGB, 1)
    assert (capture.retrieve()[1] == bgr_switched_off[..., ::-1]).all()


@pytest.mark.parametrize(
    ("property_number", "value"),
    [(cv2.CAP_PROP_FPS, 0), (cv2.CAP_PROP_FRAME_WIDTH, 1), (cv2.CAP_PROP_FRAME_WIDTH, float("nan")), (9999, 1)],
)
def test_what_cannot_be_set_is_answered_with_false_and_changes_nothing(
    live: LiveSensor, property_number: int, value: float
):
    capture = SimulatedCapture(live)
    assert capture.set(property_number, value) is False
    assert capture.get(cv2.CAP_PROP_FRAME_WIDTH) == 24
    assert capture.get(cv2.CAP_PROP_FPS) == 15
    assert capture.get(9999) == 0


def test_released_capture_opens_again_and_a_callers_array_is_filled(live: LiveSensor):
    capture = SimulatedCapture(live)
    capture.release()
    assert not capture.isOpened()
    assert capture.open(0)
    mine = np.zeros((32, 24, 3), np.uint8)
    is_read, frame = capture.read(mine)
    assert is_read
    assert frame is mine
    assert mine.any()
