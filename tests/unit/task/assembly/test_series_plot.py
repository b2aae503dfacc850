from magicsim.robot.assembly.cues import Cues
from magicsim.robot.assembly.misaligned import Misalignment
from magicsim.robot.assembly.stages import Stage
from magicsim.task.assembly.series_plot import draw_series, stage_begins, step_numbers

LONG = (Stage.GRIP, Stage.FIRST, Stage.FIRST, Stage.FIRST, Stage.SECOND, Stage.OPEN)
SHORT = (Stage.GRIP, Stage.FIRST, Stage.SECOND, Stage.SECOND)


def series(*stages: Stage) -> list[Cues]:
    return [
        Cues(
            stage=stage, outcome="held", ssim=0.6, ssim_fingers=(0.6, 0.6), similarity=0.8,
            verdicts=("Touched", "Touched"), force_n=(0.0, 0.0, 0.0), force_size_n=0.0, torque_nmm=(0.0, 0.0, 0.0),
            normal_n=4.0, slid_mm=0.0,
        )
        for stage in stages
    ]  # fmt: skip


def test_steps_of_one_stage_follow_each_other_and_stages_of_all_trials_begin_together():
    begins = stage_begins([series(*LONG), series(*SHORT)])
    assert begins == {Stage.GRIP: 0, Stage.FIRST: 1, Stage.SECOND: 4, Stage.OPEN: 6}
    assert step_numbers(LONG, begins) == [0, 1, 2, 3, 4, 6]
    assert step_numbers(SHORT, begins) == [0, 1, 4, 5]


def test_one_step_a_stage_is_the_number_of_the_stage():
    begins = stage_begins([series(*Stage)])
    assert step_numbers(tuple(Stage), begins) == list(range(6))


def test_picture_is_a_png_of_trials_of_any_length():
    trials = [(Misalignment(kind=kind), series(*each)) for kind, each in (("aligned", LONG), ("offset", SHORT))]
    picture = draw_series(trials)
    assert picture.startswith(b"\x89PNG")
    assert picture == draw_series(trials)
