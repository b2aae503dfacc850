"""Runs tasks, tries again where that can help, and yields each task's outcome as it ends."""

from collections.abc import Callable, Generator, Iterable, Iterator
from itertools import islice
from typing import Protocol, TypeVar

from magicsim.workers.attempt import Failure, FailureKind, Outcome, Prepare, Reply
from magicsim.workers.options import WorkerOptions

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")
QUEUED_PER_SLOT = 2
"""Tasks given out for each process: one that runs, one that waits, and memory stays flat."""


class Engine(Protocol):
    """What runs attempts."""

    @property
    def slots(self) -> int:
        """How many attempts run at the same time."""

    def start(self, key: int, task: object) -> None:
        """Begins an attempt at a task."""

    def wait(self) -> tuple[int, Reply]:
        """The next attempt that ends."""

    def close(self) -> None:
        """Ends everything."""


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
    engine = _engine(function, prepare, options)
    try:
        yield from _drive(engine, iter(tasks), options.retries)
    finally:
        engine.close()


def _engine(function: Callable[[TaskT], ResultT], prepare: Prepare | None, options: WorkerOptions) -> Engine:
    if options.cluster is not None:
        from magicsim.workers.cluster import ClusterPool

        return ClusterPool(function, prepare, options)
    from magicsim.workers.pool import LocalPool

    return LocalPool(function, prepare, options)


def _drive(engine: Engine, tasks: Iterator[tuple[int, TaskT]], retries: int) -> Iterator[Outcome[ResultT]]:
    running: dict[int, TaskT] = {}
    failures: dict[int, tuple[Failure, ...]] = {}
    while True:
        for key, task in islice(tasks, max(0, engine.slots * QUEUED_PER_SLOT - len(running))):
            running[key] = task
            engine.start(key, task)
        if not running:
            return
        key, reply = engine.wait()
        before = failures.pop(key, ())
        if reply.failure is not None:
            before = (*before, reply.failure)
            if reply.failure.kind != FailureKind.REFUSED and len(before) <= retries:
                failures[key] = before
                engine.start(key, running[key])
                continue
        del running[key]
        yield Outcome(key=key, result=reply.result, failures=before, seconds=reply.seconds)
