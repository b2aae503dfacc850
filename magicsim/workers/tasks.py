"""Runs tasks, tries again where that can help, and yields each task's outcome as it ends.

Attempts run on this machine (`pool`) or on the processes of a running dask.distributed cluster.
"""

import queue
from collections.abc import Callable, Generator, Iterable
from itertools import islice
from typing import Any, TypeVar

from magicsim.errors import ConfigError
from magicsim.workers.attempt import Failure, FailureKind, Outcome, Prepare, Reply, WorkerOptions, attempt, text_of
from magicsim.workers.pool import LocalPool

CONNECT_S = 20
"""How long to look for the scheduler [s]."""


class ClusterPool:
    """Runs attempts on a cluster, which should have one thread for each worker process.

    A worker process takes one task at a time, whatever its number of threads. A task that takes too long is given up;
    the cluster cannot end it.
    """

    def __init__(self, function: Callable[[Any], Any], prepare: Prepare | None, options: WorkerOptions) -> None:
        """Connects.

        Raises:
            ConfigError: dask.distributed is not installed, or no scheduler answers at the address.
        """
        try:
            import distributed

            self._client: Any = distributed.Client(options.cluster, timeout=CONNECT_S, set_as_default=False)
        except ImportError:
            raise ConfigError("cluster needs dask.distributed: pip install 'magicsim[cluster]'") from None
        except (OSError, ValueError) as error:
            raise ConfigError(f"cluster = '{options.cluster}' does not answer: {text_of(error)}") from None
        self._function, self._prepare, self._options = function, prepare, options
        self._ended: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self._running: dict[int, Any] = {}

    @property
    def slots(self) -> int:
        """Worker processes at present.

        Raises:
            ConfigError: The scheduler has gone away.
        """
        workers = self._client.scheduler_info(n_workers=-1).get("workers")
        if workers is None or self._client.status != "running":
            raise ConfigError(f"cluster = '{self._options.cluster}' no longer answers; what is finished is kept")
        return max(1, len(workers))

    def start(self, key: int, task: object) -> None:
        """Begins an attempt at a task."""
        future = self._client.submit(attempt, self._function, task, self._prepare, 1, pure=False)
        self._running[key] = future
        future.add_done_callback(lambda ended: self._ended.put((key, ended)))

    def wait(self) -> tuple[int, Reply]:
        """The next attempt that ends."""
        future: Any
        try:
            key, future = self._ended.get(timeout=self._options.timeout_s)
        except queue.Empty:
            key = next(iter(self._running))
            future = self._running[key]
            future.cancel()
            message = f"nothing ended for {self._options.timeout_s:g} s"
            return self._lost(key, FailureKind.TIMEOUT, message)
        if key not in self._running or self._running[key] is not future:
            return self.wait()
        try:
            reply: Reply = future.result()
        except Exception as error:  # dask's own: the worker was lost too often, or the task cancelled
            return self._lost(key, FailureKind.CRASH, f"{type(error).__name__}: {text_of(error)}")
        del self._running[key]
        return key, reply

    def close(self) -> None:
        """Gives up what still runs, and disconnects."""
        self._client.cancel(list(self._running.values()), force=True)
        self._client.close()

    def _lost(self, key: int, kind: FailureKind, message: str) -> tuple[int, Reply]:
        del self._running[key]
        return key, Reply(result=None, failure=Failure(kind=kind, message=message), seconds=0.0)


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
