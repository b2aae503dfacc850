"""Whole episodes of the grasp task: rendered, read and driven to their end on the default sensor."""

from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim_experiments.task.running import run_grasps
from magicsim_experiments.task.settings import GraspConfig

SHORT = {"items": ("orange",), "quality": "control", "seed": 1, "open_gap_mm": 4, "distance_mm": 150}


def events(out: Path) -> list[str]:
    rows = pq.read_table(out / "frames.parquet", columns=["event"]).to_pylist()
    return [row["event"] for row in rows if row["event"]]


@pytest.mark.slow
def test_orange_is_taken_carried_and_delivered(tmp_path: Path):
    found = run_grasps(GraspConfig(**SHORT, pull_share=0.0), tmp_path / "out", episodes=1)
    assert (found.completed.count, found.delivered.count, found.drops.count, found.failed.count) == (1, 1, 0, 0)
    assert events(tmp_path / "out") == ["appears", "offered", "let_go", "delivered"]
    rows = pq.read_table(tmp_path / "out" / "frames.parquet", columns=["upper_n", "lower_n"]).to_pylist()
    most = max(max(row.values()) for row in rows)
    assert most == pytest.approx(GraspConfig().grip_n, rel=0.02)


@pytest.mark.slow
def test_orange_that_a_hand_pulls_away_is_seen_to_slip(tmp_path: Path):
    found = run_grasps(GraspConfig(**SHORT, pull_share=1.0), tmp_path / "out", episodes=1)
    assert (found.completed.count, found.slips_missed.count, found.slips_missed.of) == (1, 0, 1)
    assert events(tmp_path / "out") == ["appears", "offered", "let_go", "pulled"]


@pytest.mark.slow
def test_dark_roll_is_seen_and_gripped_where_the_exposure_follows_and_s_stops_just_above_the_threshold(tmp_path: Path):
    """The anchor of docs/operating-point.md: with a locked exposure E stays below 0.66 and nothing closes."""
    dark = GraspConfig(**SHORT | {"items": ("biscuit-packet",)}, rig="published-run", detector="facing", pull_share=1.0)
    found = run_grasps(dark, tmp_path / "out", episodes=1)
    assert (found.false_closes.count, found.drops.count, found.failed.count) == (0, 0, 0)
    names = ["stage", "proximity", "entropy", "similarity", "upper_n"]
    rows = pq.read_table(tmp_path / "out" / "frames.parquet", columns=names).to_pylist()
    held = [row for row in rows if row["stage"] == "Closing" and row["upper_n"] > 0.99 * GraspConfig().grip_n]
    assert held
    assert {row["proximity"] for row in held} == {"Approaching"}
    assert min(row["entropy"] for row in held) > 2
    assert {round(row["similarity"], 1) for row in held} == {0.7}
    assert found.completed.count == 0  # S is 0.72, the published grasping run's threshold 0.7
