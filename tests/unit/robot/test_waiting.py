import time

import pytest

from magicsim.robot import waiting as module
from magicsim.robot.waiting import on_stderr, waiting


def test_short_wait_is_silent():
    lines: list[str] = []
    with waiting("solving", lines.append):
        pass
    assert lines == []


def test_long_wait_says_what_for_and_goes_on_saying_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "FIRST_S", 0.01)
    monkeypatch.setattr(module, "NEXT_S", 0.01)
    lines: list[str] = []

    def fail_after_two() -> None:
        with waiting("solving", lines.append):
            while len(lines) < 2:
                time.sleep(0.005)
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011 -- any will do
        fail_after_two()
    assert all(line.startswith("solving, ") for line in lines)
    count = len(lines)
    time.sleep(0.05)
    assert len(lines) == count


def test_line_goes_to_stderr(capsys: pytest.CaptureFixture[str]):
    on_stderr("solving, 2 s so far")
    assert capsys.readouterr() == ("", "magicsim: solving, 2 s so far\n")
