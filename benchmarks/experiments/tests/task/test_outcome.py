from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from magicsim_experiments.task.episode import GraspFrame, GraspRecord
from magicsim_experiments.task.running import contact_sheet, film
from magicsim_experiments.task.settings import GraspConfig, load_item
from magicsim_experiments.task.story import draw_story
from magicsim_experiments.task.summary import GraspOutcome, judge_episode, summarise

ORANGE, STORY = load_item("orange"), replace(draw_story(GraspConfig(), 0), item="orange")
EMPTY = GraspFrame(
    episode=4, frame=0, time_s=0, stage="Waiting", entropy=0.1, correlation=0, similarity=1, proximity="Normal",
    contact="Untouched", event="", has_item=False, hold="away", gap_mm=None, width_mm=88, carriage_mm=0, upper_n=0,
    lower_n=0, slid_mm=0, light=False,
)  # fmt: skip
THERE: dict[str, Any] = {"has_item": True, "hold": "placed", "gap_mm": 2.0}
GRIPPED: dict[str, Any] = {"has_item": True, "hold": "held", "gap_mm": -1.0, "upper_n": 4.0, "lower_n": 4.1}
GOOD: list[dict[str, Any]] = [
    {}, THERE, THERE | {"stage": "Closing"}, GRIPPED | {"stage": "Grasped", "hold": "placed"},
    GRIPPED | {"stage": "Transporting", "event": "let_go", "carriage_mm": 10}, GRIPPED | {"stage": "Transporting"},
]  # fmt: skip
HOME: list[dict[str, Any]] = [{"stage": "Returning", "carriage_mm": 200}, {"stage": "Waiting"}]


def judged(*rows: dict[str, Any], error: str = "") -> GraspOutcome:
    made = tuple(replace(EMPTY, **row, frame=k, time_s=k / 15) for k, row in enumerate(rows))
    return judge_episode(GraspRecord(rows=made, error=error), ORANGE, STORY, frames_per_second=15)


def test_delivered_episode_is_completed_and_its_time_adds_up():
    found = judged(*GOOD, GRIPPED | {"stage": "Returning", "event": "delivered", "carriage_mm": 300}, *HOME)
    assert found.is_completed
    assert found.is_delivered
    assert found.grasped_at_gap_mm == -1
    assert found.largest_n == 4.1
    assert sum(found.seconds_in.values()) == pytest.approx(found.frames / 15, abs=1e-5)


@pytest.mark.parametrize(("late", "is_missed"), [(0, False), (4, False), (5, True)])
def test_pulled_item_has_to_be_missed_within_five_frames(late: int, is_missed: bool):
    blind = [{"stage": "Transporting"}] * late
    first = blind[0] if blind else {"stage": "Slipped"}
    rows = [*GOOD, first | {"event": "pulled"}, *blind[1:], *([{"stage": "Slipped"}] if blind else []), *HOME]
    found = judged(*rows)
    assert found.is_pulled
    assert found.slip_delay_frames == late
    assert found.is_slip_missed is is_missed
    assert found.is_completed is not is_missed


@pytest.mark.parametrize(
    ("rows", "field", "value"),
    [
        ([{"stage": "Closing"}, *HOME], "false_closes", 1),
        ([*GOOD, GRIPPED | {"stage": "Slipped"}, *HOME], "false_slips", 1),
        ([*GOOD, {"event": "dropped", "stage": "Slipped"}, *HOME], "is_dropped", True),
        ([*GOOD, GRIPPED | {"upper_n": 26.0}, *HOME], "is_crushed", True),
        ([THERE, {"event": "withdrawn"}], "is_offer_missed", True),
    ],
)
def test_what_goes_wrong_is_named_and_nothing_is_completed(rows: list[dict[str, Any]], field: str, value: object):
    found = judged(*rows)
    assert getattr(found, field) == value
    assert not found.is_completed


def test_noise_is_counted_where_a_light_shines():
    lit = {"light": True, "proximity": "Noise"}
    assert judged({}, lit, lit | {"proximity": "Approaching"}).noise_share == 0.5
    assert judged({}).noise_share is None


def test_summary_counts_with_intervals():
    good = judged(*GOOD, GRIPPED | {"stage": "Returning", "event": "delivered", "carriage_mm": 300}, *HOME)
    bad = judged(*GOOD, {"event": "dropped", "stage": "Slipped"}, *HOME, error="no equilibrium")
    rows = [
        {"episode": 1, "stage": "Waiting", "light": True, "proximity": "Noise"},
        {"episode": 1, "stage": "Waiting", "light": True, "proximity": "Approaching"},
        {"episode": 2, "stage": "Closing", "light": False, "proximity": "Noise"},
    ]
    found = asdict(summarise([good, bad], rows, detector="calibrated", room="office", out="x"))
    assert found["lit"] == {"Waiting": {"frames": 2, "noise": 1, "episodes": 1}}
    assert (found["completed"]["count"], found["completed"]["of"]) == (1, 2)
    assert found["completed"]["low"] == pytest.approx(0.0126, abs=1e-4)  # Clopper and Pearson
    assert found["slips_missed"] == {"count": 0, "of": 0, "low": None, "high": None}
    assert found["failed"]["count"] == 1
    assert found["by_item"]["orange"]["count"] == 1


def test_pictures_of_an_episode_are_whole():
    rows = [replace(EMPTY, frame=k, stage="Closing" if k > 20 else "Waiting") for k in range(40)]
    frames = [(np.full((32, 24, 3), 6 * k, np.uint8), row) for k, row in enumerate(rows)]
    assert contact_sheet(frames)[:2] == b"\xff\xd8"
    assert film(frames, frames_per_second=15)[8:12] == b"WEBP"
    assert all(a.frame < b.frame for a, b in pairwise(rows))
