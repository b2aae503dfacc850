"""One attempt at a task, inside a worker process, and what becomes of it; and how tasks are spread over processes."""

import os
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, Self, TypeVar

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError, MagicsimError
from magicsim.light.variant import activate_variant
from magicsim.waiting import shown_elsewhere

MAX_WORKERS = 1024
"""Each is a process with the renderer in it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerOptions:
    """Nothing here changes a result: only where and when it is computed."""

    workers: int
    """Processes on this machine; ignored with a cluster, which brings its own."""
    timeout_s: float | None = None
    """Longest time for one attempt [s]; None waits for ever."""
    retries: int = 2
    """Further attempts after a crash, a timeout or an unexpected error."""
    max_tasks: int = 400
    """Tasks after which a process is replaced by a fresh one; 0 means never. Near episodes add 0.8 MB each,
    and a fresh process takes 35 s to have its sensor, a quarter of the time of 50."""
    cluster: str | None = None
    """Address of a running dask.distributed scheduler, or None for this machine."""

    @property
    def threads(self) -> int:
        """Threads for each process on this machine."""
        return max(1, usable_cores() // self.workers)


def usable_cores() -> int:
    """Cores that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def choose_workers(workers: int | None, *, cluster: str | None = None, timeout_s: float | None = None) -> WorkerOptions:
    """Options from what a user asked for.

    Args:
        workers: Processes on this machine; one for each core by default.
        cluster: Address of a dask.distributed scheduler.
        timeout_s: Longest time for one attempt [s].

    Raises:
        ConfigError: A number is not allowed, or both workers and a cluster were named.
    """
    if workers is not None:
        check_number("workers", workers, 1, MAX_WORKERS, whole=True)
    if workers is not None and cluster is not None:
        raise ConfigError(f"workers = {workers} is not allowed with a cluster, which has workers of its own")
    if cluster is not None and "://" not in cluster:
        raise ConfigError(f"cluster = '{cluster}' is not allowed: must be an address such as tcp://scheduler:8786")
    return WorkerOptions(workers=workers or usable_cores(), cluster=cluster, timeout_s=timeout_s)


ResultT = TypeVar("ResultT")


class FailureKind(StrEnum):
    """Why a task has no result."""

    REFUSED = "refused"
    """It raised a `MagicsimError`: trying again would end the same way."""
    ERROR = "error"
    """It raised anything else."""
    CRASH = "crash"
    """The process ended."""
    TIMEOUT = "timeout"
    """It took longer than allowed, and its process was ended."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """One failed attempt."""

    kind: FailureKind
    message: str
    """One line."""
    traceback: str = ""
    """Where it was raised, empty where nothing was."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome(Generic[ResultT]):
    """The end of one task."""

    key: int
    result: ResultT | None
    """What the function returned, None after the last failure."""
    failures: tuple[Failure, ...]
    """All failed attempts, in order; a task with a result may have some."""
    seconds: float
    """How long the successful attempt took in its process [s]; 0 without one."""

    @property
    def succeeded(self) -> bool:
        """Whether there is a result."""
        return self.result is not None


Prepare = Callable[[int], None]
"""Told once in each process how many threads it may use, before its first task."""
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
ORPHAN_CHECK_S = 0.5
"""How often a process looks whether the one that started it still lives [s]."""
_prepared: set[Prepare] = set()
_one_at_a_time = threading.Lock()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """What an attempt sends back; errors travel as text, so that any error can."""

    result: Any = None
    failure: Failure | None = None
    seconds: float = 0.0

    @classmethod
    def failed(cls, kind: FailureKind, message: str, traceback: str = "") -> Self:
        """The reply of an attempt without a result."""
        return cls(failure=Failure(kind=kind, message=message, traceback=traceback))

    @classmethod
    def of_error(cls, error: Exception) -> Self:
        """The reply of an attempt that ended with an error, which is being handled."""
        if isinstance(error, MagicsimError):
            return cls.failed(FailureKind.REFUSED, text_of(error), traceback.format_exc())
        return cls.failed(FailureKind.ERROR, f"{type(error).__name__}: {text_of(error)}", traceback.format_exc())


def begin_process(threads: int, parent: int) -> None:
    """First thing in a process of the pool: bounds its threads, and ends it when its parent has gone."""
    for variable in THREAD_VARIABLES:
        os.environ[variable] = str(threads)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(ORPHAN_CHECK_S)
    os._exit(1)


def attempt(function: Callable[[Any], Any], task: object, prepare: Prepare | None, threads: int) -> Reply:
    """Calls the function once; never raises."""
    with _one_at_a_time:
        start = time.perf_counter()
        try:
            if prepare is not None and prepare not in _prepared:
                prepare(threads)
                _prepared.add(prepare)
            with shown_elsewhere():  # by whoever gave out the tasks
                result = function(task)
        except Exception as error:  # whatever it is, it belongs to this task alone
            return Reply.of_error(error)
        return Reply(result=result, seconds=time.perf_counter() - start)


def text_of(error: Exception) -> str:
    """What an error says, without breaks of lines."""
    return " ".join(str(error).split())


def bound_threads(threads: int) -> None:
    """Tells the renderer of this process how many threads it may use; frames do not depend on it."""
    from magicsim.light.backend import dr

    dr.set_thread_count(threads)


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """What processes make of tasks, and what prepares them for it."""

    function: Callable[[Any], bytes]
    prepare: Prepare | None = bound_threads
    variant: Callable[[], str] = activate_variant
