"""The command line called inside the test's own process."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from magicsim.cli import main


class Shell:
    """Calls the command line inside this process."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
        self.monkeypatch, self.capsys = monkeypatch, capsys

    def __call__(self, *arguments: object) -> SimpleNamespace:
        self.monkeypatch.setattr(sys, "argv", ["magicsim", *map(str, arguments)])
        self.capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        captured = self.capsys.readouterr()
        return SimpleNamespace(code=code, out=captured.out, err=captured.err)

    def json(self, *arguments: object, code: int = 0) -> dict[str, object]:
        done = self(*arguments, "--json")
        assert done.code == code, done.err
        assert len(done.out.splitlines()) == 1
        return json.loads(done.out)

    def refusal(self, *arguments: object) -> str:
        done = self(*arguments)
        assert done.code == 2
        assert done.out == ""
        assert len(done.err.splitlines()) == 1
        assert done.err.startswith("magicsim: ")
        return done.err


@pytest.fixture
def shell(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Shell:
    monkeypatch.chdir(tmp_path)
    return Shell(monkeypatch, capsys)
