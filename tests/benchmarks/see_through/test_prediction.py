"""The committed prediction: its tables are those of its figures, and its profile is the one that judged."""

import json
from pathlib import Path

from see_through import PROFILE, TEST, TRAINING, WISHES, tables

from magicsim.detectors.profile import load_profile

ROOT = Path(__file__).parents[3]


def test_tables_are_drawn_from_the_figures():
    found = json.loads((ROOT / "docs/see-through.json").read_text(encoding="utf-8"))
    assert tables(found) == (ROOT / "docs/see-through-tables.txt").read_text(encoding="utf-8")
    assert (found["sensors"]["training"], found["sensors"]["test"]) == (TRAINING, TEST)


def test_profile_is_shipped_and_every_wish_has_a_prediction_with_intervals():
    assert load_profile("see-through-markers") == load_profile(ROOT / PROFILE)
    shares = json.loads((ROOT / "docs/see-through.json").read_text(encoding="utf-8"))["profiles"][str(PROFILE)][
        "shares"
    ]
    for name in WISHES:
        low, high = shares["all"][name]["interval"]
        assert low <= shares["all"][name]["mean"] <= high
