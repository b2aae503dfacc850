import pytest

from magicsim_experiments.task.alignment.episode import AlignmentFrame, AlignmentRecord
from magicsim_experiments.task.alignment.grip import AlignmentConfig, Grip, draw_grip
from magicsim_experiments.task.alignment.outcome import judge_episode, mean, summarise

GRIP = Grip(item="rod", askew_deg=20.0, x_mm=0.0, y_mm=0.0)


def row(frame: int, error: float, *, read: float = 0.0, episode: int = 0) -> AlignmentFrame:
    return AlignmentFrame(
        episode=episode, frame=frame, time_s=frame / 10, wrist_deg=error - 20, held_deg=20.0, error_deg=error,
        upper_deg=20 + read, lower_deg=20 - read, read_deg=20.0, hold="held", upper_n=6.0, lower_n=6.0, slid_mm=0.0,
    )  # fmt: skip


def recorded(*errors: float, dropped: bool = False, episode: int = 0, read: float = 0.0) -> AlignmentRecord:
    rows = tuple(row(k, each, episode=episode, read=read) for k, each in enumerate(errors))
    return AlignmentRecord(rows=rows, is_dropped=dropped, error="")


def judged(*errors: float, dropped: bool = False):
    return judge_episode(recorded(*errors, dropped=dropped), GRIP, episode=0, within_deg=2.0)


def test_upright_from_the_frame_after_the_last_one_beyond_the_limit():
    found = judged(20, 1.0, -3.0, 1.5, 0.5)
    assert (found.is_upright, found.seconds, found.start_deg, found.end_deg) == (True, 0.3, 20, 0.5)
    never = judged(20, 1.0, 2.5)
    assert (never.is_upright, never.seconds, never.end_deg) == (False, None, 2.5)
    assert judged(0.5).seconds == 0.0


def test_lost_item_ends_nowhere():
    lost = judged(20, 1.0, dropped=True)
    assert (lost.is_upright, lost.end_deg, lost.is_dropped) == (False, None, True)
    nothing = judge_episode(AlignmentRecord(rows=(), is_dropped=True, error=""), GRIP, episode=0, within_deg=2.0)
    assert (nothing.start_deg, nothing.turned_in_grip_deg, nothing.frames) == (None, None, 0)


def test_summary_keeps_unseen_items_and_fingers_apart():
    runs = [recorded(20, 1.0, read=3.0), recorded(20, 5.0, episode=1, read=1.0)]
    grips = [GRIP, Grip(item="pen", askew_deg=20.0, x_mm=0.0, y_mm=0.0)]
    outcomes = [
        judge_episode(run, grip, episode=k, within_deg=2.0)
        for k, (run, grip) in enumerate(zip(runs, grips, strict=True))
    ]
    rows = [each for run in runs for each in run.rows]
    found = summarise(outcomes, rows, unseen=["pen"], within_deg=2.0, out="out")
    assert (found.seen.upright.count, found.seen.upright.of) == (1, 1)
    assert (found.unseen.upright.count, found.unseen.upright.of) == (0, 1)
    assert found.seen.end_deg.value == 1.0
    assert found.seen.read_error_deg["upper finger"].value == pytest.approx(3.0)
    assert found.seen.read_error_deg["both fingers"].value == pytest.approx(0.0)  # their errors are opposite
    assert found.seen.read_error_deg["constant"].value == 20.0
    assert found.by_item["pen"].value == 5.0
    assert found.dropped.count == 0


def test_one_episode_has_no_interval():
    alone, two = mean([1.0, 3.0], [0, 0]), mean([1.0, 3.0], [0, 1])
    assert (alone.value, alone.low, alone.high, alone.episodes) == (2.0, None, None, 1)
    assert (two.value, two.low, two.high) == (2.0, 1.0, 3.0)


@pytest.mark.parametrize("items", ["a", "ab", "abc"])
def test_items_and_sides_take_turns(items):
    config = AlignmentConfig(items=tuple(items), askew_deg=(5, 40))
    grips = [draw_grip(config, number) for number in range(4 * len(items))]
    assert [each.item for each in grips] == [*items] * 4
    assert all(5 <= abs(each.askew_deg) <= 40 for each in grips)
    for item in items:
        assert {each.askew_deg > 0 for each in grips if each.item == item} == {True, False}
    assert draw_grip(config, 3) == grips[3]
