import numpy as np
import pytest

from magicsim_experiments.assembly.stages import AssemblyConfig, Misalignment, TrialStage, draw_misalignments
from magicsim_experiments.assembly.summary import CUES, Rate, change, recognise, unrecognised
from magicsim_experiments.assembly.trial import Cues

CONFIG = AssemblyConfig()


def step(stage: TrialStage, ssim: float, *, force_n: float = 0.0, verdict: str = "Touched") -> Cues:
    return Cues(
        stage=stage, outcome="held", ssim=ssim, ssim_fingers=(ssim, ssim), similarity=0.5, verdicts=(verdict, verdict),
        force_n=(0.0, -force_n, 0.0), force_size_n=force_n, torque_nmm=(0.0, 0.0, 0.0), normal_n=4.0, slid_mm=0.0,
        place=(0.0,) * 6, limit=None, time_s=0.0,
    )  # fmt: skip


def series(first: float, second: float, force_n: float, verdict: str = "Touched") -> tuple[Cues, ...]:
    return (
        step(TrialStage.APPROACH, 0.8), step(TrialStage.FIRST, first, force_n=force_n / 2),
        step(TrialStage.SECOND, second, force_n=force_n, verdict=verdict),
    )  # fmt: skip


OFF, ANGLED, RIGHT = (Misalignment(kind=kind) for kind in ("offset", "angle", "aligned"))
TRIALS = [
    (OFF, series(0.79, 0.75, 5.0, "Untouched")),
    (ANGLED, series(0.8, 0.79, 3.0)),
    (RIGHT, series(0.8, 0.78, 1.5)),
]


def test_change_is_the_largest_of_both_insertions_against_the_approach():
    assert change(TRIALS[0][1], CUES["ssim"]) == pytest.approx(0.05)
    assert change(TRIALS[0][1][:1], CUES["ssim"]) == np.inf  # lost before it was inserted


def test_cue_recognises_what_changes_more_than_every_aligned_trial():
    found = recognise(TRIALS)
    assert found["ssim"].threshold == pytest.approx(0.02)
    assert found["ssim"].misaligned.recognised == 1
    assert found["ssim"].by_kind["angle"].rate == 0
    assert found["ssim"].auc == 0.5
    assert found["force label"].misaligned.rate == 1
    assert found["force label"].auc == 1
    assert found["contact verdict"].misaligned.recognised == 1
    assert unrecognised(TRIALS).recognised == 1


def test_without_aligned_trials_nothing_can_be_recognised_by_a_change():
    found = recognise(TRIALS[:2])
    assert found["ssim"].threshold is None
    assert found["ssim"].auc is None
    assert found["ssim"].misaligned.recognised == 0


def test_interval_is_exact():
    rate = Rate.of_trials([True] * 8 + [False] * 2)
    assert (rate.low, rate.high) == pytest.approx((0.444, 0.975), abs=1e-3)
    assert Rate.of_trials([]).rate is None


def test_trials_are_drawn_in_turn_and_from_their_seed():
    drawn = draw_misalignments(30, 4, CONFIG)
    assert [each.kind for each in drawn[:4]] == ["offset", "angle", "aligned", "offset"]
    assert drawn == draw_misalignments(30, 4, CONFIG) != draw_misalignments(30, 5, CONFIG)
    for each in drawn:
        offset, angle = np.hypot(each.x_mm, each.z_mm), np.hypot(each.tilt_x_deg, each.tilt_z_deg)
        low, high = {"offset": CONFIG.offset_mm, "angle": (0, 0), "aligned": (0, CONFIG.aligned_mm)}[each.kind]
        assert low - 1e-9 <= offset <= high + 1e-9
        assert angle == 0 or CONFIG.angle_deg[0] - 1e-9 <= angle <= CONFIG.angle_deg[1] + 1e-9


def test_aligned_trial_that_lost_its_plug_early_leaves_no_threshold():
    found = recognise([*TRIALS, (RIGHT, series(0.8, 0.78, 1.5)[:1])])
    assert found["ssim"].threshold is None
    assert found["ssim"].misaligned.recognised == 0


def test_more_trials_begin_with_the_same_misalignments():
    assert draw_misalignments(40, 3, CONFIG)[:16] == draw_misalignments(16, 3, CONFIG)
