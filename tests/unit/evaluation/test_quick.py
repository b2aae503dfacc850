import time
from pathlib import Path

import numpy as np
import pytest

from evaluation.synthetic import write_suite
from magicsim.config.presets import preset_root
from magicsim.detectors.profile import load_profile
from magicsim.errors import ConfigError
from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.baseline import load_baseline
from magicsim.evaluation.detector import ProfileDetector
from magicsim.evaluation.footage import foretold_s, load_quick_set, quick_suite, shipped_films
from magicsim.evaluation.suite import SHIPPED, load_suite, refuse_settings_of_frames
from magicsim.evaluation.take import list_cases
from magicsim.frame_class import FrameClass


def test_standard_condition_is_kept_and_the_rest_is_named():
    suite = load_suite("small")
    small, left_out = quick_suite(suite)
    kept = {case.name for case in list_cases(small)}
    assert kept
    assert {case.light for case in list_cases(small)} == {suite.episodes[0].lights[0]}
    assert len(small.noises) == 1
    named = {line.removeprefix("take ") for line in left_out if line.startswith("take ")}
    assert kept | named == {case.name for case in list_cases(suite)}
    assert not kept & named
    assert f"noise {suite.noises[1].name}" in left_out


def test_time_is_foretold_from_the_takes_that_are_not_kept(tmp_path: Path):
    suite = load_suite("small")
    wanted, kept, seconds = foretold_s(suite, tmp_path, 2)
    assert (wanted, kept) == (len(list_cases(suite)), 0)
    assert seconds > foretold_s(quick_suite(suite)[0], tmp_path, 2)[2] > 0
    assert foretold_s(suite, tmp_path, 1)[2] == pytest.approx(2 * seconds)


def test_part_is_the_same_however_busy_the_machine_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    suite = load_suite(write_suite(tmp_path))
    before = [case.name for case in list_cases(quick_suite(suite)[0])]
    monkeypatch.setattr(time, "perf_counter", lambda: 1e9)
    assert [case.name for case in list_cases(quick_suite(suite)[0])] == before
    assert len(before) == 8


def test_frames_that_come_with_the_program_are_of_dark_takes_and_hold_every_class():
    suite, _ = quick_suite(load_suite(SHIPPED))
    films = [film for take in shipped_films(suite) for film in take]
    assert {film.tag.take for film in films} == {case.name for case in list_cases(suite)}
    assert len(films) == 12  # with n takes that all fall p is 2^-n
    for film in films:
        assert {each for each in film.labels.classes if each} == set(FrameClass)
        assert len(film.labels.classes) == len(load_quick_set().state)
    assert sum(path.stat().st_size for path in load_quick_set().folder.iterdir()) < 5_000_000


def test_two_frames_of_a_state_differ_by_noise_and_a_near_one_by_more():
    suite, _ = quick_suite(load_suite(SHIPPED))
    film = shipped_films(suite)[0][0]
    references, frames = list(film.images.references()), list(film.images.frames())
    assert references[0].shape == (320, 240, 3)
    assert np.mean(references) == pytest.approx(60, abs=1)
    near = film.labels.classes.index(FrameClass.NEAR)
    noise = np.std(frames[near].astype(float) - frames[near + 1])
    assert 0 < noise < 1.5
    assert np.std(frames[near] - np.mean(references, 0)) > 3 * noise


def test_verdicts_on_them_are_those_of_the_baseline_that_comes_with_the_program():
    suite, _ = quick_suite(load_suite(SHIPPED))
    film = shipped_films(suite)[0][0]
    known = load_baseline(preset_root() / "detectors/baselines/quick-calibrated.json").episodes[film.tag.name]
    profile = load_profile("calibrated")
    judged = judge_footage(film, lambda: ProfileDetector(profile), who="calibrated")
    assert judged.seen.levels == pytest.approx(known.seen.levels, abs=0.05)
    assert (judged.proximity, judged.contact) == (known.proximity, known.contact)


def test_settings_that_frames_cannot_follow_are_refused():
    refuse_settings_of_frames(["resamples=99", "rest_s=0", "rig.camera.live={}"], quick=True, existing=False)
    refuse_settings_of_frames(["design.skin_mm=0.7"], quick=False, existing=False)
    refuse_settings_of_frames(["rig=digit-rgb"], quick=False, existing=True)
    with pytest.raises(
        ConfigError, match=r"--set design.skin_mm is not allowed with --quick.* rig.camera.live; without"
    ):
        refuse_settings_of_frames(["design.skin_mm=0.7"], quick=True, existing=False)
    with pytest.raises(ConfigError, match=r"--set noises is not allowed with --on, whose frames exist"):
        refuse_settings_of_frames(["noises=[]"], quick=False, existing=True)
