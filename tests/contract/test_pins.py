"""A change of structure changes no byte: frames, forces and JSON keys are those that `pins.json` holds.

Bytes of frames and the last digits of forces follow from the processor and the libraries too. On another kind of
processor frames are not compared (`pytest -m slow tests/contract -rs` says so), and forces with friction may differ by
a few thousandths: the same code gave 0.2 % more torque of a sheared box and 1 uN m on a punch on a second kind.
"""

import json
import shlex
from pathlib import Path

import pytest

from magicsim.cli.app import app
from magicsim.cli.entry import present_words

from . import cases
from .pin import PINS

KNOWN = json.loads(PINS.read_text(encoding="utf-8"))
LINES = Path(__file__).with_name("command_lines.txt").read_text(encoding="utf-8").splitlines()
APART = ("study", "estimate", "task", "bench")
"""Commands that other distributions or scripts have."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where commands run one after the other."""
    return tmp_path_factory.mktemp("contract")


@pytest.mark.slow
@pytest.mark.parametrize("case", cases.FRAMES)
def test_frames_have_the_bytes_that_they_had(case: str, tmp_path: Path):
    if cases.processor() != KNOWN["made_on"]:
        pytest.skip(f"bytes are those of {KNOWN['made_on']}")
    assert dict(cases.FRAMES[case](tmp_path)) == KNOWN["frames"][case]


@pytest.mark.slow
def test_forces_of_the_stress_paths_are_what_they_were():
    forces = cases.forces()
    if cases.processor() == KNOWN["made_on"]:
        assert forces == KNOWN["forces"]
    assert set(forces) == set(KNOWN["forces"])
    for path, values in forces.items():
        assert values == pytest.approx(KNOWN["forces"][path], rel=3e-3, abs=2e-3), path


@pytest.mark.slow
@pytest.mark.parametrize("command", cases.COMMANDS)
def test_command_prints_the_keys_that_it_printed(command: str, folder: Path):
    if command == "real":
        cases.write_recording(folder)
    _assert_kept(KNOWN["keys"][command], cases.printed_keys(command, folder), command)


def _assert_kept(before: object, now: object, place: str) -> None:
    """Every key that there was is there and holds what it held; more keys may come."""
    if isinstance(before, dict):
        assert isinstance(now, dict), place
        assert set(before) <= set(now), f"{place}: {set(before) - set(now)}"
        for name, value in before.items():
            _assert_kept(value, now[name], f"{place}.{name}")
    elif isinstance(before, list) and isinstance(now, list):
        _assert_kept(before[0], now[0], f"{place}[0]")
    else:
        assert before == now, place


@pytest.mark.parametrize("line", [line for line in LINES if line.split()[1] not in APART])
def test_command_line_that_was_documented_once_parses(line: str):
    app.parse_args(present_words(shlex.split(line)[1:]), exit_on_error=False, print_error=False)
