"""One attempt at a task, inside a worker process."""

import os
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from magicsim.errors import MagicsimError
from magicsim.waiting import shown_elsewhere
from magicsim.workers.outcome import Failure, FailureKind

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

    result: Any
    failure: Failure | None
    seconds: float


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
        except MagicsimError as error:
            failure = Failure(kind=FailureKind.REFUSED, message=_one_line(error), traceback=traceback.format_exc())
        except Exception as error:  # whatever it is, it belongs to this task alone
            message = f"{type(error).__name__}: {_one_line(error)}"
            failure = Failure(kind=FailureKind.ERROR, message=message, traceback=traceback.format_exc())
        else:
            return Reply(result=result, failure=None, seconds=time.perf_counter() - start)
        return Reply(result=None, failure=failure, seconds=time.perf_counter() - start)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
