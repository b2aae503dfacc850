"""Attempts on this machine: fresh (spawned) processes, of which a killed one loses its own task alone.

Each process has a pipe of its own and shares nothing with the others, no queue and no lock, so that it may be killed
at any moment, also while it starts, reads or answers.
"""

import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from magicsim.workers.attempt import Failure, FailureKind, Prepare, Reply, attempt, begin_process
from magicsim.workers.options import WorkerOptions

Order = tuple[Callable[[Any], Any], object, Prepare | None, int]
"""Arguments of an attempt."""


@dataclass(slots=True, kw_only=True, eq=False)
class _Process:
    """One process and what it does."""

    process: SpawnProcess
    pipe: Connection
    """Our end."""
    key: int | None = None
    """The task that it works on."""
    deadline_s: float | None = None
    """When that has taken too long, on the monotonic clock [s]."""
    begun: int = 0
    """Tasks that it was given so far."""


@dataclass(slots=True)
class LocalPool:
    """Runs attempts in processes of this machine, which start when there is work for them."""

    function: Callable[[Any], Any]
    prepare: Prepare | None
    options: WorkerOptions
    _waiting: deque[tuple[int, object]] = field(default_factory=deque)
    _processes: list[_Process] = field(default_factory=list)
    _lost: deque[tuple[int, Reply]] = field(default_factory=deque)

    @property
    def slots(self) -> int:
        """How many attempts run at the same time."""
        return self.options.workers

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
            busy = [each for each in self._processes if each.key is not None]
            deadlines = [each.deadline_s for each in busy if each.deadline_s is not None]
            patience = max(0.0, min(deadlines) - time.monotonic()) if deadlines else None
            ready = wait([each.pipe for each in busy], patience)
            for each in busy:
                if each.pipe in ready:
                    return self._take(each)
            for each in busy:
                if each.deadline_s is not None and each.deadline_s <= time.monotonic():
                    return self._end(each, FailureKind.TIMEOUT, f"took longer than {self.options.timeout_s:g} s")

    def close(self) -> None:
        """Ends all processes, whatever they do."""
        for each in self._processes:
            each.process.kill()
        while self._processes:
            self._forget(self._processes[-1])

    def _give_out(self) -> None:
        free = [each for each in self._processes if each.key is None]
        while self._waiting and (free or len(self._processes) < self.options.workers):
            self._give(free.pop() if free else self._begin(), *self._waiting.popleft())

    def _give(self, worker: _Process, key: int, task: object) -> None:
        order: Order = (self.function, task, self.prepare, self.options.threads)
        worker.key, worker.begun = key, worker.begun + 1
        worker.deadline_s = time.monotonic() + self.options.timeout_s if self.options.timeout_s is not None else None
        try:
            worker.pipe.send(order)
        except OSError:  # it has ended meanwhile
            self._lost.append(self._end(worker, FailureKind.CRASH))

    def _take(self, worker: _Process) -> tuple[int, Reply]:
        try:
            reply: Reply = worker.pipe.recv()
        except (EOFError, OSError):
            return self._end(worker, FailureKind.CRASH)
        key, worker.key = worker.key, None
        if self.options.max_tasks and worker.begun >= self.options.max_tasks:
            self._forget(worker)  # without its pipe it ends by itself
        return _key(key), reply

    def _end(self, worker: _Process, kind: FailureKind, message: str = "") -> tuple[int, Reply]:
        """Ends a process, and the attempt that was under way in it."""
        worker.process.kill() if message else worker.process.join()
        self._forget(worker)
        worker.process.join()
        message = message or f"its process ended with code {worker.process.exitcode}"
        return _key(worker.key), Reply(result=None, failure=Failure(kind=kind, message=message), seconds=0.0)

    def _begin(self) -> _Process:
        ours, theirs = Pipe()
        arguments = (theirs, self.options.threads, os.getpid())
        process = multiprocessing.get_context("spawn").Process(target=serve, args=arguments, daemon=True)
        process.start()
        theirs.close()
        self._processes.append(_Process(process=process, pipe=ours))
        return self._processes[-1]

    def _forget(self, worker: _Process) -> None:
        worker.pipe.close()
        self._processes.remove(worker)


def serve(pipe: Connection, threads: int, parent: int) -> None:
    """What a process does: one attempt after the other, until its pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that started it ends it
    begin_process(threads, parent)
    while True:
        try:
            order: Order = pipe.recv()
            reply = attempt(*order)
        except EOFError:
            return
        except Exception as error:  # what was sent does not exist here
            reply = _failed(error)
        try:
            pipe.send(reply)
        except OSError:
            return
        except Exception as error:  # what was returned cannot be sent
            pipe.send(_failed(error))


def _failed(error: Exception) -> Reply:
    message = f"{type(error).__name__}: {' '.join(str(error).split())}"
    return Reply(result=None, failure=Failure(kind=FailureKind.ERROR, message=message), seconds=0.0)


def _key(key: int | None) -> int:
    if key is None:
        msg = "a process without a task has ended an attempt"
        raise RuntimeError(msg)
    return key
