import os
import signal
from multiprocessing import active_children
from multiprocessing.process import BaseProcess

import pytest

from magicsim.workers.attempt import WorkerOptions
from magicsim.workers.tasks import LocalPool

from .tasks import not_to_be_sent, square


@pytest.fixture
def others() -> set[BaseProcess]:
    """Processes that are there before the pool."""
    return set(active_children())


@pytest.fixture
def pool(others: set[BaseProcess]):
    found = LocalPool(square, None, WorkerOptions(workers=1, timeout_s=60))
    yield found
    found.close()


def test_process_that_is_killed_while_it_starts_or_waits_loses_one_attempt(pool: LocalPool, others: set[BaseProcess]):
    pool.start(7, 3)
    (starting,) = set(active_children()) - others
    os.kill(starting.pid, signal.SIGKILL)  # it has not even read its task
    key, reply = pool.wait()
    assert (key, str(reply.failure.kind), reply.failure.message) == (7, "crash", "its process ended with code -9")
    pool.start(7, 3)
    assert pool.wait()[1].result == 9
    (idle,) = set(active_children()) - others
    os.kill(idle.pid, signal.SIGKILL)
    idle.join()
    pool.start(8, 4)
    key, reply = pool.wait()
    assert (key, str(reply.failure.kind)) == (8, "crash")
    pool.start(8, 4)
    assert pool.wait()[1].result == 16


def test_answer_that_cannot_be_sent_is_an_error_of_its_task():
    pool = LocalPool(not_to_be_sent, None, WorkerOptions(workers=1, timeout_s=60))
    pool.start(1, 0)
    key, reply = pool.wait()
    pool.close()
    assert (key, str(reply.failure.kind)) == (1, "error")
    # Python 3.13 names the object alone
    assert "pickle" in reply.failure.message or "not_to_be_sent.<locals>" in reply.failure.message
