from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evaluation.synthetic import PROFILE, make_suite
from laboratory.injected_faults import DELAY, FAULTS, STUCK, Fault, swapped

from magicsim.config.presets import preset_root
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.errors import FrameError
from magicsim.evaluation.baseline import load_baseline, save_baseline
from magicsim.evaluation.detector import MakeDetector, ProfileDetector
from magicsim.evaluation.evaluate import Evaluation, evaluate_suite, film_suite
from magicsim.evaluation.footage import quick_suite, shipped_films
from magicsim.evaluation.suite import QUICK, SHIPPED, load_suite

SOUND = replace(PROFILE, reference_count=6)
BETTER = {"tau_b_2"}
"""What tells a touch more clearly on the made-up sensor."""

REFUSED = {"tau_b_5"}
"""What finds no grid in real frames, and is refused by its own line."""


def test_at_least_thirty_faults_of_which_those_of_a_profile_change_one_option():
    assert len(FAULTS) >= 30
    changed = [fault.make(SOUND) for fault in FAULTS.values()]
    profiles = [each.profile for each in changed if isinstance(each, ProfileDetector)]
    assert len(profiles) >= 15
    for profile in profiles:
        assert sum(getattr(profile, key) != getattr(SOUND, key) for key in SOUND.__slots__) == 1


def test_answers_come_late_or_stay():
    frames = np.random.default_rng(0).integers(20, 120, (6 + STUCK + 4, 32, 24, 3), np.uint8)
    frames[:, ::4] //= 4

    def scores(fault: Fault) -> list[float]:
        detector = fault.make(SOUND)
        detector.fit(list(frames[:6]))
        return [detector.step(each).touch for each in frames[6:]]

    right = scores(Fault(says="sound", make=ProfileDetector))
    assert len(set(right)) == len(right)
    assert scores(FAULTS["delayed"]) == [right[0]] * DELAY + right[:-DELAY]
    assert scores(FAULTS["stuck"]) == right[:STUCK] + [right[STUCK - 1]] * 4


def test_swapped_channels_are_red_and_green():
    assert swapped(np.arange(12, dtype=np.uint8).reshape(2, 2, 3))[0, 0].tolist() == [1, 0, 2]


Judge = Callable[[Callable[[DetectorProfile], object]], Evaluation]


def against_sound(folder: Path, *, objects: int, name: str) -> Judge:
    """Judges a detector as `evaluate --quick --baseline` does, the sound one's; takes are exposed once."""
    suite, cache = make_suite(folder, objects=objects, rest_s=0.0)
    suite, left_out = quick_suite(suite)
    assert left_out == ["noise high"]
    films = list(film_suite(suite, cache))

    def judge(make: MakeDetector, **options: object) -> Evaluation:
        return evaluate_suite(suite, make, name="tiny", detector=name, cache=cache, films=films, **options)

    sound = judge(lambda: ProfileDetector(PROFILE)).episodes
    save_baseline(folder / "sound.json", sound, suite="tiny", detector="sound")
    known = load_baseline(folder / "sound.json")
    return lambda make: judge(lambda: make(PROFILE), baseline=known)


@pytest.fixture(scope="module")
def strong(tmp_path_factory: pytest.TempPathFactory) -> Judge:
    return against_sound(tmp_path_factory.mktemp("strong"), objects=8, name="sound")


@pytest.fixture(scope="module")
def weak(tmp_path_factory: pytest.TempPathFactory) -> Judge:
    """Fewer takes than any test can find a fall in, and a name by which no scores are compared."""
    return against_sound(tmp_path_factory.mktemp("weak"), objects=2, name="another")


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_found_by_a_quick_evaluation_that_can_judge(strong: Judge, name: str):
    found = strong(FAULTS[name].make)
    assert found.cannot_judge is None
    if name in BETTER:
        assert found.improvements
    else:
        assert found.is_worse
        assert found.regressions


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_found_or_cannot_be_judged_on_two_takes(weak: Judge, name: str):
    found = weak(FAULTS[name].make)
    assert found.is_worse or found.cannot_judge
    assert found.is_worse or not found.collapses
    assert not found.regressions  # two takes find no fall, whatever its size


def test_faults_that_leave_a_class_without_its_name_are_found_on_two_takes(weak: Judge):
    for name in ("dead", "never_touched", "always_touched", "always_near", "always_light", "tau_e_5", "stuck"):
        assert weak(FAULTS[name].make).is_worse, name


def test_sound_detector_is_no_worse_and_says_whether_it_was_judged(strong: Judge, weak: Judge):
    sound = strong(ProfileDetector)
    assert (sound.is_worse, sound.cannot_judge, sound.collapses) == (False, None, [])
    assert all(each.smallest_fall == each.matters for each in sound.changes)
    few = weak(ProfileDetector)
    assert not few.is_worse
    assert few.cannot_judge == "2 shared takes in dark/rig, in which no fall could be found"
    assert all(each.smallest_fall is None for each in few.changes)


def test_small_suite_holds_enough_dark_takes_for_alarms():
    suite = load_suite("small")
    dark = [each for block in suite.episodes if "dark" in block.lights for each in block.objects]
    assert len(set(dark)) >= 12
    assert {each.name for each in suite.objects} == set(dark)


@pytest.fixture(scope="module")
def shipped() -> Judge:
    """Judges a detector on the frames of `evaluate --quick`, against the baseline that comes with them."""
    suite, _ = quick_suite(load_suite(SHIPPED, ["rest_s=0", "resamples=99"]))
    films, profile = shipped_films(suite), load_profile("calibrated")
    known = load_baseline(preset_root() / "detectors/baselines/quick-calibrated.json")
    return lambda make: evaluate_suite(
        suite, lambda: make(profile), name=QUICK, detector="calibrated", cache=Path(), films=films, baseline=known
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_found_on_the_frames_of_a_quick_evaluation(shipped: Judge, name: str):
    if name in REFUSED:
        with pytest.raises(FrameError, match="reference frames show no grid"):
            shipped(FAULTS[name].make)
        return
    found = shipped(FAULTS[name].make)
    assert found.cannot_judge is None
    assert found.beside.frames_changed == []
    assert found.is_worse


@pytest.mark.slow
def test_sound_detector_passes_on_the_frames_of_a_quick_evaluation(shipped: Judge):
    found = shipped(ProfileDetector)
    assert (found.is_worse, found.cannot_judge, found.beside.verdicts_changed) == (False, None, [])
