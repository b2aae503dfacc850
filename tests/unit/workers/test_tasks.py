import os
from pathlib import Path

import pytest

from magicsim.workers.attempt import WorkerOptions
from magicsim.workers.tasks import dealt, run_tasks

from .tasks import fail_at_first, prepare, process_and_threads, refuse, square


def test_every_task_ends_once_whatever_the_order():
    outcomes = list(run_tasks(square, enumerate(range(7)), WorkerOptions(workers=2)))
    assert {outcome.key: outcome.result for outcome in outcomes} == {number: number**2 for number in range(7)}
    assert len(outcomes) == 7
    assert not any(outcome.failures for outcome in outcomes)


def test_task_that_is_refused_is_not_tried_again_and_says_why():
    (outcome,) = run_tasks(refuse, [(5, 5)], WorkerOptions(workers=1))
    assert (outcome.key, outcome.succeeded) == (5, False)
    assert [(failure.kind, failure.message) for failure in outcome.failures] == [
        ("refused", "number = 5 is not allowed")
    ]
    assert "refuse" in outcome.failures[0].traceback


def test_killed_failing_and_endless_attempts_are_repeated_and_harm_no_other_task(tmp_path: Path):
    options = WorkerOptions(workers=2, timeout_s=5, retries=2)
    tasks = [(number, (str(tmp_path), number)) for number in range(6)]
    outcomes = {outcome.key: outcome for outcome in run_tasks(fail_at_first, tasks, options)}
    kinds = {key: [str(failure.kind) for failure in outcome.failures] for key, outcome in outcomes.items()}
    assert kinds == {0: [], 1: ["crash"], 2: ["error"] * 2, 3: ["crash"] * 3, 4: ["timeout"], 5: []}
    assert {key for key, outcome in outcomes.items() if outcome.succeeded} == {0, 1, 2, 4, 5}
    assert outcomes[2].failures[0].message == "RuntimeError: weather"


def test_processes_are_told_their_threads_and_replaced_after_their_share_of_tasks():
    options = WorkerOptions(workers=1, max_tasks=2)
    outcomes = run_tasks(process_and_threads, enumerate(range(4)), options, prepare=prepare)
    processes, threads = zip(*(outcome.result for outcome in outcomes), strict=True)
    assert os.getpid() not in processes
    assert len(set(processes)) == 2
    assert set(threads) == {f"{options.threads} and {options.threads}"}


def test_tasks_are_drawn_only_as_processes_become_free():
    drawn = []

    def tasks():
        for number in range(100):
            drawn.append(number)
            yield number, number

    outcomes = run_tasks(square, tasks(), WorkerOptions(workers=1))
    next(outcomes)
    assert len(drawn) <= 3
    outcomes.close()


@pytest.mark.slow
def test_cluster_gives_the_same_outcomes_and_survives_a_killed_worker(tmp_path: Path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        options = WorkerOptions(workers=1, cluster=cluster.scheduler_address)
        outcomes = {outcome.key: outcome.result for outcome in run_tasks(square, enumerate(range(20)), options)}
        assert outcomes == {number: number**2 for number in range(20)}
        killed = run_tasks(fail_at_first, [(number, (str(tmp_path), number)) for number in range(3)], options)
        assert {outcome.key: outcome.result for outcome in killed} == {0: 0, 1: 1, 2: 2}


def test_processes_begin_with_groups_of_their_own() -> None:
    assert list(dealt(range(10), lambda number: number // 3, 2)) == [0, 3, 1, 4, 2, 5, 6, 9, 7, 8]
    assert list(dealt([], lambda number: number, 2)) == []
