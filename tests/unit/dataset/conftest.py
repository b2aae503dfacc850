from pathlib import Path

import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.workers.attempt import Outcome, WorkerOptions, attempt

from .fakes import FAKE, small_recipe


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Attempts in this process, where a test is not about processes: starting one takes a second."""

    def run_here(function, tasks, options, *, prepare=None):
        del options
        for key, task in tasks:
            reply = attempt(function, task, prepare, 1)
            failures = (reply.failure,) if reply.failure is not None else ()
            yield Outcome(key=key, result=reply.result, failures=failures, seconds=reply.seconds)

    monkeypatch.setattr("magicsim.dataset.generate.run_tasks", run_here)


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished dataset of eleven episodes that cost nothing."""
    out = tmp_path_factory.mktemp("whole") / "set"
    generate_dataset(small_recipe("episodes=11"), out, options=WorkerOptions(workers=1), simulator=FAKE)
    return out
