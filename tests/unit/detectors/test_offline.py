import numpy as np
import pytest

from magicsim.detectors import DetectorProfile, detect, detect_sources, fuse
from magicsim.errors import PresetError

from .conftest import grid_frame, near_frame


@pytest.fixture
def folders(tmp_path, save):
    for index in range(30):
        save(tmp_path / "rest" / f"{index:02}.png", grid_frame())
    save(tmp_path / "near.png", near_frame())
    return tmp_path


def test_verdicts_equal_those_of_arrays_in_memory(folders):
    profile = DetectorProfile()
    expected = detect(near_frame(), fuse([grid_frame()] * 30, profile), profile, source="near.png")
    assert detect_sources(folders / "near.png", folders / "rest", "published") == [expected]
    assert detect_sources(folders / "near.png", folders / "rest", profile) == [expected]


def test_unknown_profile_is_refused(folders):
    with pytest.raises(PresetError, match="nope"):
        detect_sources(folders / "near.png", folders / "rest", "nope")


def test_references_of_a_touched_sensor_are_warned_about(folders, save, caplog):
    for index in range(24, 30):
        save(folders / "rest" / f"{index:02}.png", grid_frame(shift=3))
    detect_sources(folders / "near.png", folders / "rest", "published")
    assert "6 of 30 reference frames do not look untouched beside the others, the first of them frame 24" in caplog.text


def test_references_of_an_untouched_sensor_are_not(folders, caplog):
    detect_sources(folders / "near.png", folders / "rest", "published")
    assert not caplog.records


def test_spread_at_rest_is_told_in_the_units_that_touches_set(tmp_path, save, monkeypatch):
    random = np.random.default_rng(0)
    for index in range(30):
        noisy = grid_frame() + random.normal(0, 4, grid_frame().shape)
        save(tmp_path / "rest" / f"{index:02}.png", np.clip(noisy, 0, 255).astype(np.uint8))
    save(tmp_path / "touch.png", grid_frame(shift=3))
    touches = []

    def recorded(image, references, profile, **named):
        touches.append(references.rest.touch)
        return detect(image, references, profile, **named)

    monkeypatch.setattr("magicsim.detectors.offline.detect", recorded)
    detect_sources(tmp_path / "rest", tmp_path / "rest", "rest-relative", touches=tmp_path / "touch.png")
    assert len(touches) == 60  # the references, for their spread, and the frames
    assert None not in touches
