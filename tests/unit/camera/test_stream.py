import numpy as np
import pytest

from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import Flicker, LedDrift, LiveExposure, Mjpeg, Shutter
from magicsim.camera.exposure import expose, through_mjpeg
from magicsim.camera.stream import CameraMemory, CameraStream, Instant
from magicsim.errors import RenderError

SILENT = {"full_well_e": 1e12, "read_noise_e": 0.0, "fixed_pattern": 0.0, "blur_px": 0.0, "columns": 16, "rows": 20}
NOISY = {"full_well_e": 4000.0, "columns": 16, "rows": 20}
LIVE = LiveExposure(time_constant_frames=3.0, white_balance_frames=6.0, tolerance=0.0)
RATE = 15.0


def flat(*levels: float) -> np.ndarray:
    return np.broadcast_to(np.array(levels, np.float32), (20, 16, 3)).copy()


def at(index: int, seed: int = 3) -> Instant:
    return Instant(seed=seed, index=index, time_s=index / RATE, frames_per_second=RATE)


def filmed(stream: CameraStream, lights: list[np.ndarray], *, first: int = 0, memory: CameraMemory | None = None):
    """Frames, and the memory before each of them and after the last."""
    memory, images, memories = memory or stream.begin(RATE), [], []
    for index, light in enumerate(lights, first):
        memories.append(memory)
        image, memory = stream.take(light, memory, at(index))
        images.append(image)
    return images, [*memories, memory]


def test_without_effects_frames_are_those_of_a_locked_exposure_each_by_itself():
    camera, lights = Camera(**NOISY), [flat(0.2, 0.2, 0.2), flat(0.5, 0.1, 0.3)]
    stream = CameraStream.of(camera, lights[0])
    images, _ = filmed(stream, lights)
    assert not camera.history
    for index, (image, light) in enumerate(zip(images, lights, strict=True)):
        assert (image == expose(light, stream.gain, camera, seed=3, frame=index)).all()


def test_live_exposure_begins_where_the_untouched_sensor_has_settled_and_stays_there():
    camera = Camera(live=LIVE, exposure_grey=90, **SILENT)
    images, _ = filmed(CameraStream.of(camera, flat(0.1, 0.2, 0.7)), [flat(0.1, 0.2, 0.7)] * 5)
    assert all((image == 90).all() for image in images)


def test_live_exposure_brings_a_darker_image_back_and_the_next_one_is_too_bright():
    camera = Camera(live=LIVE, exposure_grey=90, **SILENT)
    lights = [flat(0.2, 0.2, 0.2)] * 2 + [flat(0.1, 0.1, 0.1)] * 40 + [flat(0.2, 0.2, 0.2)]
    images, _ = filmed(CameraStream.of(camera, lights[0]), lights)
    assert [int(images[place][0, 0, 0]) for place in (1, 2, 41, 42)] == [90, 45, 90, 180]


def test_a_gain_twice_as_high_shows_half_the_electrons():
    camera = Camera(live=LIVE, exposure_grey=100, **NOISY | {"fixed_pattern": 0.0, "read_noise_e": 30.0})
    lights = [flat(0.2, 0.2, 0.2)] + [flat(0.1, 0.1, 0.1)] * 60
    images, _ = filmed(CameraStream.of(camera, lights[0]), lights)
    signal = 100 / 255
    electrons = signal * 4000 / 2
    expected = (255 / 2000) ** 2 * (electrons + 30.0**2) + 1 / 12
    assert np.var(np.array(images[40:], float)) == pytest.approx(expected, rel=0.05)  # 20160 samples: 1 %


@pytest.mark.parametrize(
    "effects",
    [{"live": LIVE}, {"shutter": Shutter(row_us=2000.0, moves=True)}, {"live": LIVE, "shutter": Shutter(moves=True)}],
)
def test_a_stream_taken_up_in_its_middle_has_the_same_bytes(effects: dict):
    stream = CameraStream.of(Camera(**NOISY, **effects), flat(0.2, 0.2, 0.2))
    lights = [flat(*np.random.default_rng(k).random(3)) for k in range(8)]
    images, memories = filmed(stream, lights)
    again, _ = filmed(stream, lights[5:], first=5, memory=memories[5])
    assert all((a == b).all() for a, b in zip(images[5:], again, strict=True))
    passed = stream.begin(RATE)
    for index, light in enumerate(lights[:5]):
        passed = stream.passed(light, passed, at(index))
    unseen, _ = filmed(stream, lights[5:], first=5, memory=passed)
    assert all((a == b).all() for a, b in zip(images[5:], unseen, strict=True))


def test_a_state_that_returns_is_another_frame():
    """What was between them shows, beside the noise."""
    stream = CameraStream.of(Camera(live=LIVE, **SILENT), flat(0.2, 0.2, 0.2))
    images, _ = filmed(stream, [flat(0.2, 0.2, 0.2), flat(0.6, 0.6, 0.6), flat(0.2, 0.2, 0.2), flat(0.2, 0.2, 0.2)])
    assert images[0].mean() > images[3].mean() + 5


def test_mains_swing_is_of_the_room_alone():
    camera = Camera(flicker=Flicker(depth=0.5), shutter=Shutter(exposure_ms=1.0, row_us=300.0), **SILENT)
    room = flat(0.0, 0.1, 0.2)
    stream = CameraStream.of(camera, flat(0.2, 0.2, 0.2), room=room)
    images, _ = filmed(stream, [flat(0.2, 0.2, 0.2)] * 3)
    swings = np.ptp(np.array(images, float), axis=(0, 1, 2))
    assert swings[0] == 0
    assert swings[2] / swings[1] == pytest.approx(2, rel=0.05)
    assert swings[2] == pytest.approx(2 * 0.5 * 90 * np.sinc(0.1), rel=0.1)
    assert (np.ptp(np.array(images, float), axis=2) == 0).all()  # bands lie along rows
    dark, _ = filmed(CameraStream.of(camera, flat(0.2, 0.2, 0.2)), [flat(0.2, 0.2, 0.2)] * 3)
    assert np.ptp(np.array(dark)) == 0


def test_an_object_that_hides_the_room_hides_its_swing_and_no_pixel_falls_below_black():
    camera = Camera(flicker=Flicker(depth=1.0), shutter=Shutter(exposure_ms=0.1), exposure_grey=200, **SILENT)
    stream = CameraStream.of(camera, flat(0.2, 0.2, 0.2), room=flat(0.2, 0.2, 0.2))
    images, _ = filmed(stream, [flat(0.01, 0.0, 0.01)] * 6)
    assert np.array(images)[..., 0].max() <= 200 * 0.01 / 0.2 * 2 + 1
    assert np.array(images)[..., 1].max() == 0


def test_leds_wander_and_the_room_does_not():
    camera = Camera(led_drift=LedDrift(share=0.1, time_s=1.0), **SILENT)
    room = flat(0.2, 0.0, 0.1)
    stream = CameraStream.of(camera, flat(0.2, 0.2, 0.2), room=room)
    images, _ = filmed(stream, [flat(0.2, 0.2, 0.2)] * 200)
    deviation = np.array(images, float).std((0, 1, 2))
    assert deviation[0] == 0
    assert deviation[1] > 1.5 * deviation[2] > 3


def test_time_that_was_summed_up_gives_the_same_bytes():
    camera = Camera(flicker=Flicker(depth=0.5), shutter=Shutter(exposure_ms=1.0), led_drift=LedDrift(), **NOISY)
    stream = CameraStream.of(camera, flat(0.2, 0.2, 0.2), room=flat(0.1, 0.1, 0.1))
    summed = 0.0
    for _ in range(1000):
        summed += 1 / RATE
    times = [Instant(seed=3, index=1000, time_s=time, frames_per_second=RATE) for time in (1000 / RATE, summed)]
    assert times[0].time_s != times[1].time_s
    images = [stream.take(flat(0.2, 0.2, 0.2), stream.begin(RATE), time)[0] for time in times]
    assert (images[0] == images[1]).all()


def test_compressed_frames_are_what_comes_out():
    camera = Camera(compression=Mjpeg(kind="mjpeg", quality=30), **NOISY)
    image = filmed(CameraStream.of(camera, flat(0.2, 0.2, 0.2)), [flat(0.2, 0.2, 0.2)])[0][0]
    plain = Camera(**NOISY)
    noisy = filmed(CameraStream.of(plain, flat(0.2, 0.2, 0.2)), [flat(0.2, 0.2, 0.2)])[0][0]
    assert (image == through_mjpeg(noisy, camera.compression)).all()
    assert (image != noisy).any()


def test_rows_that_take_longer_than_a_frame_are_one_line():
    stream = CameraStream.of(Camera(shutter=Shutter(row_us=4000.0), **NOISY), flat(0.2, 0.2, 0.2))
    with pytest.raises(RenderError, match=r"row_us = 4000 is not allowed: 20 rows are read in 80 ms") as error:
        stream.take(flat(0.2, 0.2, 0.2), stream.begin(RATE), at(0))
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("effects", [{}, {"live": LIVE}, {"led_drift": LedDrift(share=0.02)}])
def test_noise_knows_nothing_of_what_is_seen(effects: dict):
    """The deviates of a frame are those of its number: two scenes of one brightness have one noise."""
    stream = CameraStream.of(Camera(vibration_px=0.0, **NOISY, **effects), flat(0.2, 0.2, 0.2))
    left, right = flat(0.2, 0.2, 0.2), flat(0.2, 0.2, 0.2)
    left[:, :8] *= 1.2
    left[:, 8:] *= 0.8
    right[:, :8] *= 0.8
    right[:, 8:] *= 1.2
    first, second = (filmed(stream, [flat(0.2, 0.2, 0.2), each, flat(0.2, 0.2, 0.2)])[0][2] for each in (left, right))
    assert (first == second).all()
