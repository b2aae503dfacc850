"""The page's tables are those of its figures, and drawn takes are what they are said to be."""

import json
from pathlib import Path

import numpy as np
import pytest
from laboratory.rest_relative.cameras import Recording, nearer
from laboratory.rest_relative.judging import FALLS, judge, thresholds
from laboratory.rest_relative.takes import COATED, TYPES, draw_takes
from rest_relative import tables

from magicsim.frame_class import FrameClass

ROOT = Path(__file__).parents[3]


def test_tables_of_the_page_are_those_of_its_figures():
    found = json.loads((ROOT / "docs/see-through.json").read_text(encoding="utf-8"))
    assert tables(found) == (ROOT / "docs/see-through-tables.txt").read_text(encoding="utf-8")


def test_takes_are_drawn_alike_each_time_and_show_every_state():
    drawn = draw_takes(4)
    assert [each.name for each in drawn[: len(TYPES)]] == [f"{name}-00" for name in TYPES]
    assert [each.scene for each in drawn[:3]] == [each.scene for each in draw_takes(1)[:3]]
    assert {each.type for each in drawn if each.name.endswith("01")} == set(TYPES) - set(COATED)
    for each in drawn:
        gaps = [frame.gap_mm for frame in each.scene.keyframes if frame.gap_mm is not None]
        assert min(gaps) <= -0.45
        assert any(gap > 0 for gap in gaps) is (each.type not in COATED)
        assert any(frame.flashlight for frame in each.scene.keyframes) is (each.type not in COATED)


def test_threshold_is_the_middle_of_falls_that_are_as_good():
    touched, untouched = np.where(FALLS < 0.04, 1.0, 0.0), np.where(FALLS < 0.01, 1.0, 0.0)
    found = thresholds({"one": [np.array([touched, untouched, untouched])]})
    assert found["fall"] == pytest.approx(0.02, rel=0.1)


def test_a_recording_is_judged_from_near_as_from_far():
    random = np.random.default_rng(1)
    picture = np.tile(np.linspace(40, 90, 160)[None, :, None], (120, 1, 3))
    rows, columns = np.indices((120, 160))
    spot = np.exp(-((rows - 60) ** 2 + (columns - 80) ** 2) / 2 / 8**2)[..., None]
    shots = [np.uint8(np.rint(picture * (1 + share * spot) + random.normal(0, 0.7, picture.shape)))
             for share in (*(0,) * 20, 1.5, 1.5)]  # fmt: skip
    recording = Recording(
        name="x/0", type="x", references=shots[:10], frames=shots[10:],
        classes=(*(FrameClass.CLEAR,) * 10, FrameClass.CONTACT, FrameClass.CONTACT),
        depth_mm=np.array([*(np.nan,) * 10, 0.8, 0.8]), stepped=np.zeros(12, bool),
    )  # fmt: skip
    assert nearer(recording).frames[0].shape == (84, 84, 3)
    for each in (recording, nearer(recording)):
        assert judge(each).measures["balanced"] == 1.0
    assert judge(recording, with_own_touches=True).measures["touched"] == 1.0
    assert judge(recording, fall=0.5).measures["touched"] == 0.0
