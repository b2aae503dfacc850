import math

import pytest

from magicsim.judge.changed_frames import runs
from magicsim.report.text import gap_or_depth, number, percent, scientific, short_name, span


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.234, "1.23"), (-1.0, "\u22121.00"), (-0.001, "0.00"), (None, "\u2013"), (math.nan, "\u2013")],
)
def test_number_has_fixed_decimals_and_a_dash_for_nothing(value, text):
    assert number(value) == text


def test_words_for_values():
    assert percent(0.9667) == "96.7\u00a0%"
    assert percent(None) == "\u2013"
    assert scientific(3.14e-7) == "3.1e-07"
    assert (span(3, 3), span(3, 5)) == ("frame 3", "frames 3\u20135")
    assert (short_name("demo"), short_name("/some/where/mine.toml")) == ("demo", "mine.toml")


@pytest.mark.parametrize(
    ("gap", "text"),
    [
        (None, "no object"),
        (1.2, "gap 1.20\u00a0mm"),
        (0.0, "depth 0.00\u00a0mm"),
        (-0.5, "depth 0.50\u00a0mm"),
    ],
)
def test_gap_turns_into_depth_where_pressed(gap, text):
    assert gap_or_depth(gap) == text


def test_runs_cover_every_place_once():
    found = [(places.start, places.stop, value) for value, places in runs("aabccc")]
    assert found == [(0, 2, "a"), (2, 3, "b"), (3, 6, "c")]
    assert list(runs([])) == []
