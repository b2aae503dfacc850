"""One place for the newest request: what was not taken in time is replaced, and nothing queues up."""

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class Mailbox(Generic[T]):
    """Holds at most one request."""

    def __init__(self) -> None:
        """Empty and open."""
        self._changed = threading.Condition()
        self._newest: T | None = None
        self._is_closed = False
        self._replaced = 0

    def put(self, request: T) -> None:
        """Leaves a request; one that is still waiting is dropped. Never waits."""
        with self._changed:
            self._replaced += self._newest is not None
            self._newest = request
            self._changed.notify()

    def take(self, timeout_s: float | None = None) -> T | None:
        """The newest request, waiting for one; None when the box is closed, or nothing came in time.

        Args:
            timeout_s: Longest wait [s]; without end by default.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self._is_closed, timeout_s)
            if self._is_closed:
                return None
            taken, self._newest = self._newest, None
            return taken

    def close(self) -> None:
        """Lets whoever waits go; may be called again."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        return self._is_closed

    @property
    def is_waiting(self) -> bool:
        """Whether a request waits."""
        return self._newest is not None

    @property
    def replaced(self) -> int:
        """How many requests were dropped for a newer one."""
        return self._replaced
