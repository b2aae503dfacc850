from pathlib import Path

import pytest

from magicsim.workers.attempt import attempt
from magicsim.workers.outcome import Outcome


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Attempts in this process, where a test is not about processes: starting one takes a second."""

    def run_here(function, tasks, options, *, prepare=None):
        del options
        for key, task in tasks:
            reply = attempt(function, task, prepare, 1)
            failures = (reply.failure,) if reply.failure is not None else ()
            yield Outcome(key=key, result=reply.result, failures=failures, seconds=reply.seconds)

    monkeypatch.setattr("magicsim.study.stages.pieces.run_tasks", run_here)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "study"
