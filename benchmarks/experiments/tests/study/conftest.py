from pathlib import Path

import pytest

from magicsim.workers.attempt import Outcome, attempt


def stay_here(monkeypatch: pytest.MonkeyPatch, *homes: str) -> None:
    """Attempts of modules in this process: starting one takes a second, with PyTorch more."""

    def run_here(function, tasks, options, *, prepare=None):
        del options
        for key, task in tasks:
            reply = attempt(function, task, prepare, 1)
            failures = (reply.failure,) if reply.failure is not None else ()
            yield Outcome(key=key, result=reply.result, failures=failures, seconds=reply.seconds)

    for home in homes:
        monkeypatch.setattr(f"{home}.run_tasks", run_here)


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces in this process, where a test is not about processes."""
    stay_here(monkeypatch, "magicsim_experiments.study.stages")


@pytest.fixture
def learns_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Data and training in this process."""
    stay_here(monkeypatch, "magicsim_experiments.study.stages", "magicsim.dataset.generate")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "study"
