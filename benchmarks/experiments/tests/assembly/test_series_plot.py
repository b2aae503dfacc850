from magicsim_experiments.assembly.stages import Misalignment, TrialStage
from magicsim_experiments.assembly.summary import draw_series, stage_ends_s
from magicsim_experiments.assembly.trial import Cues

LONG = (TrialStage.GRIP, TrialStage.FIRST, TrialStage.FIRST, TrialStage.FIRST, TrialStage.SECOND, TrialStage.OPEN)
SHORT = (TrialStage.GRIP, TrialStage.FIRST, TrialStage.SECOND, TrialStage.SECOND)


def series(*stages: TrialStage) -> list[Cues]:
    return [
        Cues(
            stage=stage, outcome="held", ssim=0.6, ssim_fingers=(0.6, 0.6), similarity=0.8,
            verdicts=("Touched", "Touched"), force_n=(0.0, 0.0, 0.0), force_size_n=0.0, torque_nmm=(0.0, 0.0, 0.0),
            normal_n=4.0, slid_mm=0.0, place=(0.0,) * 6, limit=None, time_s=float(number),
        )
        for number, stage in enumerate(stages)
    ]  # fmt: skip


def test_stages_end_where_they_do_in_most_trials():
    ends = stage_ends_s([series(*LONG), series(*SHORT), series(*SHORT)])
    assert ends == {TrialStage.GRIP: 0.0, TrialStage.FIRST: 1.0, TrialStage.SECOND: 3.0, TrialStage.OPEN: 5.0}


def test_picture_is_a_png_of_trials_of_any_length():
    trials = [(Misalignment(kind=kind), series(*each)) for kind, each in (("aligned", LONG), ("offset", SHORT))]
    picture = draw_series(trials)
    assert picture.startswith(b"\x89PNG")
    assert picture == draw_series(trials)
