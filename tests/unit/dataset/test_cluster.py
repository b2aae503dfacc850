import os
import signal
import threading
from pathlib import Path

import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.errors import ConfigError
from magicsim.workers.attempt import WorkerOptions

from .fakes import FAKE, content, small_recipe

distributed = pytest.importorskip("distributed")


@pytest.mark.slow
def test_cluster_that_loses_a_worker_ends_with_the_same_content(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("FAKE_SECONDS", "0.3")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        victim = next(iter(cluster.workers.values())).pid
        killed = threading.Event()

        def kill_once(_: object) -> None:
            if not killed.is_set():
                killed.set()
                os.kill(victim, signal.SIGKILL)

        options = WorkerOptions(workers=1, cluster=cluster.scheduler_address)
        summary = generate_dataset(
            small_recipe("episodes=11"), tmp_path / "set", options=options, simulator=FAKE, progress=kill_once
        )
    assert killed.is_set()
    assert summary.failed == 0
    assert content(tmp_path / "set") == content(whole)


@pytest.mark.slow
def test_scheduler_that_goes_away_is_one_line_and_what_is_finished_is_kept(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("FAKE_SECONDS", "0.3")
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None)
    options = WorkerOptions(workers=1, cluster=cluster.scheduler_address)
    with pytest.raises(ConfigError, match="no longer answers"):
        generate_dataset(
            small_recipe("episodes=11"), tmp_path / "set", options=options, simulator=FAKE,
            progress=lambda _: cluster.close(),
        )  # fmt: skip
    generate_dataset(
        small_recipe("episodes=11"), tmp_path / "set", options=WorkerOptions(workers=1), simulator=FAKE, resume=True
    )
    assert content(tmp_path / "set") == content(whole)


@pytest.mark.slow
def test_scheduler_that_does_not_answer_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("magicsim.workers.tasks.CONNECT_S", 1)
    options = WorkerOptions(workers=1, cluster="tcp://127.0.0.1:9")
    with pytest.raises(ConfigError, match=r"cluster = 'tcp://127\.0\.0\.1:9' does not answer"):
        generate_dataset(small_recipe(), tmp_path / "set", options=options, simulator=FAKE)
