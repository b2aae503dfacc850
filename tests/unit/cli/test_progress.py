import time
from types import SimpleNamespace

import pytest

from magicsim.cli import progress
from magicsim.cli.progress import show_progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A clock that only the test moves."""
    hands = SimpleNamespace(now=100.0)
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: hands.now))
    for variable in ("FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(variable, raising=False)
    return hands


def test_plain_lines_give_part_time_and_estimate(clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]):
    with show_progress("demo") as report:
        clock.now += 20
        report(1, 4)
    assert capsys.readouterr().err == "demo: 25%, 20 s so far, about 60 s left\n"


def test_plain_lines_come_at_most_every_ten_seconds_and_at_the_end(
    clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]
):
    with show_progress("demo") as report:
        for done in range(1, 31):
            clock.now += 1
            report(done, 30)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in lines] == ["demo: 33%", "demo: 67%", "demo: 100%"]
    assert lines[-1].endswith("about 0 s left")


def test_work_that_begins_is_named_at_once_and_in_the_lines_that_follow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.5)
    with show_progress("set") as report:
        report(0, 9, "drawing")
        report(0, 9, "drawing")
        report(0, 9, "rendering")
        time.sleep(1.0)
    lines = capsys.readouterr().err.splitlines()
    assert lines[:2] == ["set: 0%, 0 s so far, drawing", "set: 0%, 0 s so far, rendering"]
    assert lines[2:]
    assert all(line.endswith("s so far, rendering") for line in lines[2:])


def test_quick_work_says_only_that_it_is_done(clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]):
    with show_progress("demo") as report:
        for done in range(1, 4):
            clock.now += 0.1
            report(done, 3)
    assert capsys.readouterr().err.splitlines() == ["demo: 100%, 0 s so far, about 0 s left"]


def test_work_that_reports_nothing_for_long_is_told_to_go_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.05)
    with show_progress("press"):
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    time.sleep(0.1)
    assert set(lines) == {"press: 0 s so far"}
    assert 2 <= len(lines) <= 6
    assert capsys.readouterr().err == ""


def test_nothing_goes_to_standard_output(
    clock: SimpleNamespace, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    with show_progress("demo") as report:
        report(1, 1)
    monkeypatch.setenv("FORCE_COLOR", "1")  # as on a terminal
    with show_progress("demo") as report:
        report(1, 1)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "100%" in captured.err
