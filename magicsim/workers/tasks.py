"""Runs tasks, tries again where that can help, and yields each task's outcome as it ends."""

from collections.abc import Callable, Generator, Iterable
from itertools import islice
from typing import TypeVar

from magicsim.workers.attempt import Failure, FailureKind, Outcome, Prepare
from magicsim.workers.cluster import ClusterPool
from magicsim.workers.options import WorkerOptions
from magicsim.workers.pool import LocalPool

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")
QUEUED_PER_SLOT = 2
"""Tasks given out for each process: one that runs, one that waits, and memory stays flat."""


def run_tasks(
    function: Callable[[TaskT], ResultT],
    tasks: Iterable[tuple[int, TaskT]],
    options: WorkerOptions,
    *,
    prepare: Prepare | None = None,
) -> Generator[Outcome[ResultT]]:
    """Calls a function on every task in other processes.

    Tasks are idempotent: one that was lost is run again. Closing the iterator ends the processes.

    Args:
        function: Importable by name; takes a task, returns something other than None.
        tasks: Numbered tasks, drawn as processes become free.
        options: Where and how.
        prepare: Called once in each process with its number of threads.

    Yields:
        One outcome a task, in the order in which they end.

    Raises:
        ConfigError: The cluster cannot be used.
    """
    pool: ClusterPool | LocalPool
    pool = (ClusterPool if options.cluster is not None else LocalPool)(function, prepare, options)
    waiting, running = iter(tasks), dict[int, TaskT]()
    failures: dict[int, tuple[Failure, ...]] = {}
    try:
        while True:
            for key, task in islice(waiting, max(0, pool.slots * QUEUED_PER_SLOT - len(running))):
                running[key] = task
                pool.start(key, task)
            if not running:
                return
            key, reply = pool.wait()
            before = failures.pop(key, ())
            if reply.failure is not None:
                before = (*before, reply.failure)
                if reply.failure.kind != FailureKind.REFUSED and len(before) <= options.retries:
                    failures[key] = before
                    pool.start(key, running[key])
                    continue
            del running[key]
            yield Outcome(key=key, result=reply.result, failures=before, seconds=reply.seconds)
    finally:
        pool.close()
