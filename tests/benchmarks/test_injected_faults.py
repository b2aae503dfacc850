from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evaluation.synthetic import PROFILE
from laboratory.injected_faults import FAULTS, SwappedChannels

from magicsim.evaluation.baseline import load_baseline, save_baseline
from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.suite import load_suite


def test_every_fault_differs_from_the_sound_detectors_in_what_it_says():
    frames = np.random.default_rng(0).integers(20, 120, (8, 32, 24, 3), np.uint8)
    frames[:, ::4] //= 4
    sound = replace(PROFILE, reference_count=6)
    for name, fault in FAULTS.items():
        detector = fault.make(sound)
        detector.fit(list(frames[:6]))
        detector.step(frames[6])
        if name != "swapped":
            assert detector.profile != sound
            assert sum(getattr(detector.profile, key) != getattr(sound, key) for key in sound.__slots__) == 1


def test_swapped_channels_change_frames_and_not_references(monkeypatch: pytest.MonkeyPatch):
    seen: list[np.ndarray] = []

    class Watch:
        def fit(self, references: Sequence[np.ndarray]) -> None:
            seen.extend(references)

        def step(self, frame: np.ndarray) -> None:
            seen.append(frame)

    monkeypatch.setattr("laboratory.injected_faults.ProfileDetector", lambda profile: Watch())
    detector = SwappedChannels(PROFILE)
    frame = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    detector.fit([frame])
    detector.step(frame)
    assert (seen[0] == frame).all()
    assert seen[1][0, 0].tolist() == [1, 0, 2]


@pytest.mark.slow
def test_a_swapped_channel_raises_an_alarm_on_a_made_up_sensor(evaluate: Callable[..., Evaluation], tmp_path: Path):
    file = tmp_path / "sound.json"
    save_baseline(file, evaluate().episodes, suite="tiny", detector="sound")
    known = load_baseline(file)
    assert evaluate(lambda: SwappedChannels(PROFILE), baseline=known).regressions
    assert not evaluate(seed=3, baseline=known).regressions


def test_small_suite_holds_enough_dark_takes_for_alarms():
    suite = load_suite("small")
    dark = [each for block in suite.episodes if "dark" in block.lights for each in block.objects]
    assert len(set(dark)) >= 12
    assert {each.name for each in suite.objects} == set(dark)
