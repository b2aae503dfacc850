import threading
import time
from collections.abc import Callable

import pytest

import magicsim.waiting as module
from magicsim.waiting import on_stderr, shown_elsewhere, unheard, waiting


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Lines that were told, which come after a hundredth of a second."""
    monkeypatch.setattr(module, "FIRST_S", 0.01)
    monkeypatch.setattr(module, "NEXT_S", 0.01)
    return []


def until(holds: Callable[[], bool]) -> None:
    """Waits for the other thread; a test that hangs ends by its own time limit."""
    for _ in range(2000):
        if holds():
            return
        time.sleep(0.005)
    pytest.fail("nothing was told within 10 s")


def test_short_wait_is_silent():
    lines: list[str] = []
    with waiting("solving", lines.append):
        pass
    assert lines == []


def test_long_wait_says_what_for_and_goes_on_saying_it_until_it_ends(lines: list[str]):
    def fail_after_two() -> None:
        with waiting("solving", lines.append):
            until(lambda: len(lines) >= 2)
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011 -- any will do
        fail_after_two()
    assert all(line.startswith("solving, ") and line.endswith(" s so far") for line in lines)
    count = len(lines)
    time.sleep(0.05)
    assert len(lines) == count


def test_wait_inside_another_joins_it(lines: list[str], monkeypatch: pytest.MonkeyPatch):
    inner: list[str] = []
    clock = iter(range(0, 1000, 7))
    with monkeypatch.context() as patched:
        patched.setattr(module.time, "monotonic", lambda: next(clock))
        with waiting("a reset", lines.append):
            until(lambda: "a reset, 7 s so far" in lines)
            with waiting("closing", inner.append), waiting("solving", inner.append):
                until(lambda: lines[-1].startswith("a reset: solving, "))
                assert sum(each.name == "magicsim-waiting" for each in threading.enumerate()) == 1
            count = len(lines)
            until(lambda: len(lines) > count + 1)
            assert lines[-1].startswith("a reset, ")
    seconds = [int(line.rpartition(", ")[2].split()[0]) for line in lines]
    assert seconds == list(range(7, 7 * len(lines) + 1, 7))  # all from the beginning of the outer one
    assert inner == []


def test_inner_wait_that_fails_is_left(lines: list[str]):
    with waiting("a reset", lines.append):
        with pytest.raises(ValueError), waiting("solving"):  # noqa: PT011 -- any will do
            raise ValueError
        until(lambda: bool(lines))
    assert lines[0].startswith("a reset, ")


def test_share_of_the_work_stands_in_the_lines(lines: list[str]):
    with waiting("simulating", lines.append) as share:
        share(0, 0)
        until(lambda: bool(lines) and lines[-1].startswith("simulating, "))
        share(3, 12, "a note")
        until(lambda: lines[-1].startswith("simulating (25%), "))


def test_wait_is_silent_where_something_else_shows_it(lines: list[str]):
    with shown_elsewhere(), waiting("simulating", lines.append) as share, waiting("solving", lines.append):
        share(1, 2)
        time.sleep(0.05)
    assert lines == []
    with waiting("simulating", lines.append):
        until(lambda: bool(lines))


def test_threads_wait_by_themselves(lines: list[str]):
    mine: list[str] = []

    def work() -> None:
        with waiting("solving", mine.append):
            until(lambda: bool(mine))

    with waiting("a window", lines.append):
        other = threading.Thread(target=work)
        other.start()
        other.join()
    assert mine[0].startswith("solving, ")


def test_line_goes_to_stderr_or_nowhere(capsys: pytest.CaptureFixture[str]):
    on_stderr("solving, 2 s so far")
    unheard("solving, 2 s so far")
    assert capsys.readouterr() == ("", "magicsim: solving, 2 s so far\n")
