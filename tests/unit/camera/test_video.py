import sys

import numpy as np
import pytest

from magicsim.camera.effect_settings import H264
from magicsim.camera.exposure import VideoCodec
from magicsim.errors import ConfigError


def noisy(frames: int, noise: float = 2.0) -> list[np.ndarray]:
    random = np.random.default_rng(0)
    row, column = np.indices((48, 64))
    base = np.stack([80 + row, 80 + column, 150 - row], -1)
    return [np.clip(base + random.normal(0, noise, base.shape), 0, 255).astype(np.uint8) for _ in range(frames)]


def coded(images: list[np.ndarray], **settings) -> list[np.ndarray]:
    codec = VideoCodec(H264(kind="h264", **settings), rows=48, columns=64, frames_per_second=15.0)
    return [codec.through(each) for each in images]


def test_missing_pyav_is_one_line(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ConfigError, match=r"needs PyAV; `pip install magicsim\[video\]`") as error:
        coded([])
    assert len(str(error.value).splitlines()) == 1


def test_every_frame_comes_out_at_once_and_the_stream_repeats():
    pytest.importorskip("av")
    first, second = coded(noisy(8)), coded(noisy(8))
    assert len(first) == 8
    assert all((a == b).all() for a, b in zip(first, second, strict=True))
    assert all(each.shape == (48, 64, 3) for each in first)


def test_a_frame_depends_on_those_before():
    pytest.importorskip("av")
    images = noisy(6)
    assert (coded(images)[5] != coded(images[:2] + images[5:])[2]).any()


def test_prediction_takes_noise_between_frames_off_and_a_worse_rate_more():
    pytest.importorskip("av")

    def wobble(images: list[np.ndarray]) -> float:
        return float(np.diff(np.array(images, float), axis=0).std())

    images = noisy(12)
    assert wobble(coded(images, crf=30)) < wobble(coded(images, crf=15)) < wobble(images)


def test_picture_is_kept_but_for_the_rate():
    pytest.importorskip("av")
    images = noisy(5, noise=0.0)
    errors = [np.abs(coded(images, crf=crf)[-1].astype(float) - images[-1]).mean() for crf in (5, 25, 45)]
    assert errors == sorted(errors)
    assert errors[0] < 1.5
