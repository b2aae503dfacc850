import json
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError, PresetError
from magicsim_experiments.study.lighting import light_modes
from magicsim_experiments.study.lighting.color_measures import (
    CHANNELS,
    SIDES,
    around,
    brightening,
    disparity,
    share_brighter,
    unevenness,
)
from magicsim_experiments.study.lighting.light_modes import event_rows, mode_rows
from magicsim_experiments.study.running import run_study
from magicsim_experiments.study.study_file import load_study


def test_measures_of_colours():
    rest = np.full((40, 30, 3), 60, np.uint8)
    mask = np.zeros((40, 30), bool)
    mask[18:22, 13:17] = True
    where = around(mask)
    assert where.sum() > mask.sum()
    touched = rest.copy()
    touched[where] += np.array([30, 0, 0], np.uint8)
    assert disparity(rest, where) == 0
    assert disparity(touched, where) == pytest.approx(np.std([90, 60, 60]) / 70)
    assert share_brighter(rest, touched, where) == 1.0
    change = brightening(rest, touched, where)
    assert change["red"] == {"-x": 30.0, "+x": 30.0, "-y": 30.0, "+y": 30.0}
    assert set(change["green"].values()) == {0.0}
    assert unevenness(rest) == [0.0, 0.0, 0.0]
    slope = np.repeat(np.linspace(20, 100, 30)[None, :, None], 40, 0).repeat(3, 2)
    assert all(0.1 < each < 0.5 for each in unevenness(slope.astype(np.uint8)))


def test_shares_of_ways_sum_to_one_with_their_errors():
    random = np.random.default_rng(1)
    draws = [
        {"lights": ["-x", "room"], "radiance": random.uniform(size=(2, 4, 4, 3)).tolist(),
         "events": [[0.1, 0.8, 40.0, 3.5, 1.0]] * 2, "lost": 0.0}
        for _ in range(5)
    ]  # fmt: skip
    rows = list(mode_rows(1.46, draws))
    for part in {row["part"] for row in rows}:
        own = [row for row in rows if row["part"] == part]
        assert sum(row["share"] for row in own) == pytest.approx(1.0)
        assert sum(row["red"] for row in own) == pytest.approx(1.0)
        assert all(row["se"] > 0 for row in own)
    assert [row["light"] for row in event_rows(1.46, draws)] == ["-x", "room"]


def test_small_form_writes_tables(tmp_path: Path, in_process: None, monkeypatch: pytest.MonkeyPatch):
    def quietly(scene) -> bytes:
        assert scene.rig.camera.columns == 120
        values = {"unevenness": [0.5, 0.2, 0.5], "disparity": [0.1, 0.2, 0.3], "brighter": 0.9,
                  "change": {name: dict.fromkeys(SIDES, 1.0) for name in CHANNELS}}  # fmt: skip
        return json.dumps(values).encode()

    monkeypatch.setattr(light_modes, "touched", quietly)
    study = load_study("light-modes", ["paths=5000"], quick=True)
    run_study(study, tmp_path / "out", variant=lambda: "none")
    found = json.loads((tmp_path / "out/results.json").read_text())
    ways = found["tables"]["ways"]
    same = [row for row in ways if row["infill_ior"] == 1.49 and row["kind"] != "refraction alone"]
    assert all(row["share"] == 0 for row in same)  # the body's index: nothing is reflected
    usual = {row["kind"]: row["share"] for row in ways if row["infill_ior"] == 1.46 and "light" in row["part"]}
    assert usual["internal reflection"] > usual["external reflection"] > 0.02
    assert {(row["rig"], row["room"]) for row in found["tables"]["colors"]} == {
        ("two-pairs", "dark"), ("two-pairs", "office")
    }  # fmt: skip


def test_what_cannot_be_followed_is_refused():
    with pytest.raises(ConfigError, match="there are no walls"):
        load_study("light-modes", design="uniform-block")
    with pytest.raises(PresetError, match="unknown rig 'sun'"):
        load_study("light-modes", ["rigs=['sun']"])
