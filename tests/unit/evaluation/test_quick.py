import time
from pathlib import Path

import pytest

from magicsim.evaluation import footage
from magicsim.evaluation.footage import foretold_s, quick_films, quick_suite
from magicsim.evaluation.suite import load_suite
from magicsim.evaluation.take import list_cases


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


def test_takes_stop_where_another_would_be_too_long(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    clock = iter(range(0, 10_000, 25))  # every look at the clock is 25 s later
    monkeypatch.setattr(footage.time, "perf_counter", lambda: float(next(clock)))
    monkeypatch.setattr(footage, "film_case", lambda case, suite, cache: [case])
    small, left_out = quick_suite(load_suite("small"))
    before = len(left_out)
    taken = [case for [case] in quick_films(small, tmp_path, left_out, begun=0.0)]
    assert 1 <= len(taken) < len(list_cases(small))
    assert len(taken) + len(left_out) - before == len(list_cases(small))
    assert [case.role for case in taken[:2]] == ["held_out", "training"]


def test_first_take_is_made_however_slow_the_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(footage, "film_case", lambda case, suite, cache: [case])
    small, left_out = quick_suite(load_suite("small"))
    assert next(quick_films(small, tmp_path, left_out, begun=time.perf_counter() - 1000.0))


def test_time_is_foretold_from_the_takes_that_are_not_kept(tmp_path: Path):
    suite = load_suite("small")
    wanted, kept, seconds = foretold_s(suite, tmp_path, 2)
    assert (wanted, kept) == (len(list_cases(suite)), 0)
    assert seconds > foretold_s(quick_suite(suite)[0], tmp_path, 2)[2] > 0
    assert foretold_s(suite, tmp_path, 1)[2] == pytest.approx(2 * seconds)
