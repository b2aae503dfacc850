"""A small form of `benchmarks/fuzz_inputs.py`, and that it sees what it looks for."""

import importlib.util
import sys
from pathlib import Path

import pytest

from magicsim.errors import ConfigError

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "fuzz_inputs.py"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch):
    spec = importlib.util.spec_from_file_location("fuzz_inputs", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", [11, 12])
def test_broken_toml_is_loaded_or_refused_in_one_line(script, tmp_path: Path, seed: int):
    found = script.fuzz_toml(150, seed, tmp_path)
    assert found.is_sound, found
    assert found.loaded > 5
    assert found.refused > 75


def test_broken_files_are_read_or_refused_in_one_line(script, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    found = script.fuzz_files(160, 11, tmp_path)
    capfd.readouterr()
    assert found.is_sound, found
    assert found.loaded > 5
    assert found.refused > 75


@pytest.mark.parametrize(
    ("error", "is_sound"),
    [(ConfigError("a\nb"), True), (KeyError("x"), False), (RecursionError(), False), (SystemExit(1), False)],
)
def test_traceback_is_counted(script, tmp_path: Path, error: BaseException, is_sound: bool):
    def read(_: Path) -> None:
        raise error

    found = script.Found()
    script.try_file(read, tmp_path / "a", "a", found)
    assert found.is_sound == is_sound


@pytest.mark.parametrize(("line", "is_readable"), [("a", True), ("", False), ("a\n", False), ("x" * 501, False)])
def test_line_is_judged(script, line: str, is_readable: bool):
    assert script.is_readable(line) == is_readable
