import os

import pytest

from magicsim.cli.foresight import check_memory, episode_bytes, long_work
from magicsim.errors import ConfigError
from magicsim.scenes.scene import MAX_FRAMES, load_scene


def scene(last: int, *settings: str):
    return load_scene("near", [f"keyframes=[{{frame=0, gap_mm=1}}, {{frame={last}, gap_mm=2}}]", *settings])


def test_frames_have_a_bound():
    assert scene(MAX_FRAMES - 1).frame_count == MAX_FRAMES
    with pytest.raises(ConfigError, match=r"keyframes\.1\.frame = 1000000000 is not allowed: must be a whole number"):
        scene(10**9)


def test_memory_grows_with_frames_and_labels():
    few, many = episode_bytes(scene(99)), episode_bytes(scene(9999))
    assert many / few == pytest.approx((10_000 + 30) / (100 + 30), rel=0.01)
    assert episode_bytes(scene(99, "output.displacements=false")) < few


def test_episode_that_does_not_fit_into_memory_is_refused(monkeypatch: pytest.MonkeyPatch):
    check_memory(scene(99))
    monkeypatch.setattr(os, "sysconf", lambda name: {"SC_PHYS_PAGES": 1000, "SC_PAGE_SIZE": 4096}[name])
    with pytest.raises(ConfigError, match="130 frames of 240 x 320 pixels"):
        check_memory(scene(99))


def test_only_long_work_is_worth_a_line():
    assert long_work(scene(1)) is None
    assert "frames to simulate" in (long_work(scene(MAX_FRAMES - 1)) or "")
