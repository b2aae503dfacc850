"""Runs tasks, tries again where that can help, and yields each task's outcome as it ends.

Attempts run on the processes of a running dask.distributed cluster, or on this machine: in fresh (spawned) processes,
of which a killed one loses its own task alone. Each has a pipe of its own and shares nothing with the others, no queue
and no lock, so that it may be killed at any moment, also while it starts, reads or answers. `concurrent.futures` gives
up all processes with the one that ended, and ends none that takes too long.
"""

import math
import multiprocessing
import os
import queue
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby, islice, zip_longest
from multiprocessing.connection import Connection, Pipe, wait
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from magicsim.errors import ConfigError
from magicsim.workers.attempt import (
    Failure,
    FailureKind,
    Outcome,
    Prepare,
    Reply,
    WorkerOptions,
    attempt,
    begin_process,
    text_of,
)


@dataclass(slots=True, kw_only=True, eq=False)
class _Worker:
    """One process and what it does."""

    process: SpawnProcess
    pipe: Connection
    key: int = -1
    """The task that it was given last."""
    deadline_s: float = math.inf
    """When that has taken too long, on the monotonic clock [s]."""
    begun: int = 0
    """Tasks that it was given so far."""


class LocalPool:
    """Runs attempts in processes of this machine, which start when there is work for them."""

    def __init__(self, function: Callable[[Any], Any], prepare: Prepare | None, options: WorkerOptions) -> None:
        self._function, self._prepare, self._options = function, prepare, options
        self._waiting: deque[tuple[int, object]] = deque()
        self._free: list[_Worker] = []
        self._busy: dict[Connection, _Worker] = {}
        self._lost: deque[tuple[int, Reply]] = deque()

    @property
    def slots(self) -> int:
        """How many attempts run at the same time."""
        return self._options.workers

    def start(self, key: int, task: object) -> None:
        """Begins an attempt at a task, as soon as a process is free."""
        self._waiting.append((key, task))
        self._give_out()

    def wait(self) -> tuple[int, Reply]:
        """The next attempt that ends."""
        while True:
            self._give_out()
            if self._lost:
                return self._lost.popleft()
            until = min(each.deadline_s for each in self._busy.values())
            ready = wait(list(self._busy), None if until == math.inf else max(0.0, until - time.monotonic()))
            for pipe, worker in self._busy.items():
                if pipe in ready:
                    del self._busy[pipe]
                    return self._take(worker)
            for pipe, worker in self._busy.items():
                if worker.deadline_s <= time.monotonic():
                    del self._busy[pipe]
                    worker.process.kill()
                    return self._end(worker, FailureKind.TIMEOUT, f"took longer than {self._options.timeout_s:g} s")

    def close(self) -> None:
        """Ends all processes, whatever they do."""
        for each in (*self._free, *self._busy.values()):
            each.process.kill()
            each.pipe.close()
        self._free, self._busy = [], {}

    def _give_out(self) -> None:
        while self._waiting and (self._free or len(self._busy) < self._options.workers):
            worker = self._free.pop() if self._free else self._begin()
            worker.key, task = self._waiting.popleft()
            worker.begun += 1
            worker.deadline_s = time.monotonic() + (self._options.timeout_s or math.inf)
            try:
                worker.pipe.send((self._function, task, self._prepare, self._options.threads))
            except OSError:  # it has ended meanwhile
                self._lost.append(self._end(worker, FailureKind.CRASH))
            else:
                self._busy[worker.pipe] = worker

    def _take(self, worker: _Worker) -> tuple[int, Reply]:
        try:
            reply: Reply = worker.pipe.recv()
        except (EOFError, OSError):
            return self._end(worker, FailureKind.CRASH)
        if self._options.max_tasks and worker.begun >= self._options.max_tasks:
            worker.pipe.close()  # without it the process ends by itself
        else:
            self._free.append(worker)
        return worker.key, reply

    def _end(self, worker: _Worker, kind: FailureKind, message: str = "") -> tuple[int, Reply]:
        """Takes leave of a process that has ended, or was killed, and of the attempt that was under way in it."""
        worker.process.join()
        worker.pipe.close()
        return worker.key, Reply.failed(kind, message or f"its process ended with code {worker.process.exitcode}")

    def _begin(self) -> _Worker:
        ours, theirs = Pipe()
        arguments = (theirs, self._options.threads, os.getpid())
        process = multiprocessing.get_context("spawn").Process(target=serve, args=arguments, daemon=True)
        process.start()
        theirs.close()
        return _Worker(process=process, pipe=ours)


def serve(pipe: Connection, threads: int, parent: int) -> None:
    """What a process does: one attempt after the other, until its pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that started it ends it
    begin_process(threads, parent)
    while True:
        try:
            reply = attempt(*pipe.recv())
        except EOFError:
            return
        except Exception as error:  # what was sent does not exist here
            reply = Reply.of_error(error)
        try:
            pipe.send(reply)
        except OSError:
            return
        except Exception as error:  # what was returned cannot be sent
            pipe.send(Reply.of_error(error))


CONNECT_S = 20
"""How long to look for the scheduler [s]."""


class ClusterPool:
    """Runs attempts on a cluster, which should have one thread for each worker process.

    A worker process takes one task at a time, whatever its number of threads. A task that takes too long is given up;
    the cluster cannot end it.
    """

    def __init__(self, function: Callable[[Any], Any], prepare: Prepare | None, options: WorkerOptions) -> None:
        """Connects; `ConfigError` where dask.distributed is not installed, or no scheduler answers."""
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
        """Worker processes at present; `ConfigError` where the scheduler has gone away."""
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
            key, future = next(iter(self._running.items()))
            future.cancel()
            reply = Reply.failed(FailureKind.TIMEOUT, f"nothing ended for {self._options.timeout_s:g} s")
        else:
            if key not in self._running or self._running[key] is not future:
                return self.wait()
            try:
                reply = future.result()
            except Exception as error:  # dask's own: the worker was lost too often, or the task cancelled
                reply = Reply.failed(FailureKind.CRASH, f"{type(error).__name__}: {text_of(error)}")
        del self._running[key]
        return key, reply

    def close(self) -> None:
        """Gives up what still runs, and disconnects."""
        self._client.cancel(list(self._running.values()), force=True)
        self._client.close()


TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")
QUEUED_PER_SLOT = 2
"""Tasks given out for each process: one that runs, one that waits, and memory stays flat."""


def dealt(numbers: Iterable[int], group: Callable[[int], object], hands: int) -> Iterator[int]:
    """Numbers in the order in which so many processes do not compute what a group shares at the same time."""
    groups = (list(each) for _, each in groupby(numbers, group))
    while under_way := list(islice(groups, hands)):
        yield from (number for turn in zip_longest(*under_way) for number in turn if number is not None)


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
