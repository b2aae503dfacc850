"""Attempts on this machine: fresh (spawned) processes, of which a killed one loses its own task alone.

Each process has a pipe of its own and shares nothing with the others, no queue and no lock, so that it may be killed
at any moment, also while it starts, reads or answers. `concurrent.futures` gives up all processes with the one that
ended, and ends none that takes too long.
"""

import math
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from magicsim.workers.attempt import (
    Failure,
    FailureKind,
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
    """Our end."""
    key: int = -1
    """The task that it was given last."""
    deadline_s: float = math.inf
    """When that has taken too long, on the monotonic clock [s]."""
    begun: int = 0
    """Tasks that it was given so far."""


class LocalPool:
    """Runs attempts in processes of this machine, which start when there is work for them."""

    def __init__(self, function: Callable[[Any], Any], prepare: Prepare | None, options: WorkerOptions) -> None:
        """Takes what an attempt calls; nothing is started yet."""
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
        message = message or f"its process ended with code {worker.process.exitcode}"
        return worker.key, Reply(result=None, failure=Failure(kind=kind, message=message), seconds=0.0)

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
            reply = _failed(error)
        try:
            pipe.send(reply)
        except OSError:
            return
        except Exception as error:  # what was returned cannot be sent
            pipe.send(_failed(error))


def _failed(error: Exception) -> Reply:
    message = f"{type(error).__name__}: {text_of(error)}"
    return Reply(result=None, failure=Failure(kind=FailureKind.ERROR, message=message), seconds=0.0)
