from pathlib import Path

import pytest

from magicsim.sweep.comparison import DesignTask
from magicsim.sweep.designs import list_designs
from magicsim.sweep.result import DesignResult
from magicsim.workers.attempt import Outcome, attempt

from .fakes import result_of, small_sweep


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Attempts in this process, where a test is not about processes: starting one takes a second."""

    def run_here(function, tasks, options, *, prepare=None):
        del options
        for key, task in tasks:
            reply = attempt(function, task, prepare, 1)
            failures = (reply.failure,) if reply.failure is not None else ()
            yield Outcome(key=key, result=reply.result, failures=failures, seconds=reply.seconds)

    monkeypatch.setattr("magicsim.sweep.comparison.run_tasks", run_here)


@pytest.fixture
def results() -> list[DesignResult]:
    """Four designs on a grid of two cells and two skins, and one with another core."""
    sweep = small_sweep("also=[{'design.core_mm'=3.0}]")
    return [result_of(DesignTask(design=design, sweep=sweep)) for design in list_designs(sweep)]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "sweep"
