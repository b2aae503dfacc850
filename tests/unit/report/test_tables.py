import math
from dataclasses import replace

import pytest

from magicsim.detectors.verdict import Contact
from magicsim.judge.score import contact_right, proximity_right
from magicsim.report.page import scene_facts
from magicsim.report.tables import contact_table, list_mistakes, proximity_table, solve_rows
from report.synthetic import make_episode, make_judgement


@pytest.fixture(scope="module")
def episode():
    return make_episode()


@pytest.fixture(scope="module")
def judgement(episode):
    return make_judgement(episode, tau_e=1.9, tau_g=0.6)


def test_tables_hold_the_counts_of_the_score(judgement):
    for table, task in (
        (proximity_table(judgement.score), judgement.score.proximity),
        (contact_table(judgement.score), judgement.score.contact),
    ):
        assert tuple(row.counts for row in table.rows) == task.confusion


def test_right_cells_of_a_row_add_up_to_its_recall(judgement):
    for table, task in (
        (proximity_table(judgement.score), judgement.score.proximity),
        (contact_table(judgement.score), judgement.score.contact),
    ):
        for row, recall in zip(table.rows, task.recall.values(), strict=True):
            right = sum(count for column, count in zip(table.columns, row.counts, strict=True) if column in row.right)
            assert right / sum(row.counts) == pytest.approx(recall)


def test_mistakes_agree_with_the_score(episode, judgement):
    pairs = [(one, frame.truth.frame_class) for one, frame in zip(judgement.verdicts, episode.scored, strict=True)]
    for right, table in (
        (proximity_right, proximity_table(judgement.score)),
        (contact_right, contact_table(judgement.score)),
    ):
        wrong = sum(
            count
            for row in table.rows
            for column, count in zip(table.columns, row.counts, strict=True)
            if column not in row.right
        )
        assert sum(right(*pair) is False for pair in pairs) == wrong


def test_mistakes_name_stream_indices_and_join_neighbours(episode, judgement):
    mistakes = list_mistakes(episode.scored, judgement.verdicts)
    frames = {frame.truth.index: frame for frame in episode.frames}
    assert any(each.last > each.first for each in mistakes)
    for each in mistakes:
        assert frames[each.first].truth.frame_class == frames[each.last].truth.frame_class == each.truth


def test_unknown_on_a_light_frame_is_right(episode, judgement):
    verdict, frame = judgement.verdicts[-1], episode.scored[-1]
    assert verdict.combined is Contact.UNKNOWN
    assert contact_right(verdict, frame.truth.frame_class) is True


def test_solve_rows_name_the_worst_frames(episode):
    rows = {row.name: row for row in solve_rows(episode.frames)}
    deepest = max(episode.frames, key=lambda frame: frame.truth.depth_mm)
    assert rows["smallest Jacobian"].value == "0.720"
    assert rows["smallest Jacobian"].index == deepest.truth.index
    assert rows["most iterations of a frame"].value == "8"
    assert rows["deepest penetration"].value == "1.4e-06\u00a0mm"


def test_figure_that_is_not_a_number_counts_as_the_worst(episode):
    frames = list(episode.scored)
    place = next(k for k, frame in enumerate(frames) if frame.truth.contact)
    truth = frames[place].truth
    bad = replace(truth, solve=replace(truth.solve, force_balance=math.nan))
    frames[place] = replace(frames[place], truth=bad)
    row = next(row for row in solve_rows(frames) if row.name == "worst force balance")
    assert (row.value, row.index) == ("\u2013", truth.index)


def test_nothing_solved_gives_no_rows():
    assert solve_rows(make_episode([{"frame": 0}, {"frame": 3}]).frames) == []


def test_facts_describe_the_scene(episode):
    facts = scene_facts(episode)
    assert facts["Object"] == "sphere: radius 5 mm"
    assert facts["Frames"] == "3 references, 90 scored, 15 per second"
    assert facts["Design"] == "24 x 32 x 6.6 mm, skin 0.8 mm, no grid"


def test_facts_of_an_empty_scene_say_so():
    assert scene_facts(make_episode([{"frame": 0}]))["Object"] == "none"
