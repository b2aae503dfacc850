"""Attempts on this machine: a pool of fresh (spawned) processes, in which a killed one loses its own task alone."""

import multiprocessing
import os
import queue
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from concurrent.futures import TimeoutError as TookTooLong
from typing import Any

from pebble import ProcessExpired, ProcessPool

from magicsim.workers.attempt import Prepare, Reply, attempt, begin_process
from magicsim.workers.options import WorkerOptions
from magicsim.workers.outcome import Failure, FailureKind


class LocalPool:
    """Runs attempts in processes of this machine."""

    def __init__(self, function: Callable[[Any], Any], prepare: Prepare | None, options: WorkerOptions) -> None:
        """Starts nothing yet; the processes start with the first task."""
        self.slots = options.workers
        self._function, self._prepare, self._options = function, prepare, options
        self._ended: queue.SimpleQueue[tuple[int, Future[Reply]]] = queue.SimpleQueue()
        self._pool = ProcessPool(
            max_workers=options.workers,
            max_tasks=options.max_tasks,
            initializer=begin_process,
            initargs=(options.threads, os.getpid()),
            context=multiprocessing.get_context("spawn"),
        )

    def start(self, key: int, task: object) -> None:
        """Begins an attempt at a task."""
        arguments = (self._function, task, self._prepare, self._options.threads)
        future = self._pool.schedule(attempt, args=arguments, timeout=self._options.timeout_s)
        future.add_done_callback(lambda ended: self._ended.put((key, ended)))

    def wait(self) -> tuple[int, Reply]:
        """The next attempt that ends."""
        key, future = self._ended.get()
        try:
            return key, future.result()
        except TookTooLong:
            return key, _lost(FailureKind.TIMEOUT, f"took longer than {self._options.timeout_s:g} s")
        except ProcessExpired as error:
            return key, _lost(FailureKind.CRASH, f"its process ended with code {error.exitcode}")
        except (CancelledError, OSError, RuntimeError) as error:
            return key, _lost(FailureKind.CRASH, f"{type(error).__name__}: {' '.join(str(error).split())}")

    def close(self) -> None:
        """Ends all processes, whatever they do."""
        self._pool.stop()  # type: ignore[no-untyped-call]
        self._pool.join()


def _lost(kind: FailureKind, message: str) -> Reply:
    return Reply(result=None, failure=Failure(kind=kind, message=message), seconds=0.0)
