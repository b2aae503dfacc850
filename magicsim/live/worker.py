"""The thread that solves and renders, so that the window never waits for it: the newest wish wins."""

import logging
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from magicsim.errors import MagicsimError
from magicsim.live.session import Session
from magicsim.live.sight import Sight, Wish

T = TypeVar("T")


class Mailbox(Generic[T]):
    """Holds at most one request."""

    def __init__(self) -> None:
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
        """The newest request, waiting for one; None when the box is closed, or nothing came in time."""
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


LOGGER = logging.getLogger(__name__)
READY = "ready"


class Worker:
    """Carries out wishes, one after the other, and shows each twice: the lattice first, then with the frame.

    Where something passes in the room, the next frame is shown when no wish comes in a frame's time.
    """

    def __init__(self, session: Session, show: Callable[[Sight], None], failed: Callable[[str], None]) -> None:
        self._session, self._show, self._failed = session, show, failed
        self._wishes: Mailbox[Wish] = Mailbox()
        self._thread = threading.Thread(target=self._work, name="magicsim-live", daemon=True)
        self._busy_since: float | None = None
        self._doing = READY

    def start(self) -> None:
        """Begins to work."""
        self._thread.start()

    def ask(self, wish: Wish) -> None:
        """Leaves a wish; one that waits is dropped for it. Never waits."""
        self._wishes.put(wish)

    def told(self, line: str) -> None:
        """Takes note of what is being done."""
        self._doing = line

    @property
    def busy(self) -> tuple[str, float] | None:
        """What is being done and for how long [s]; None when nothing is."""
        since = self._busy_since
        return None if since is None else (self._doing, time.monotonic() - since)

    @property
    def is_asked(self) -> bool:
        """Whether a newer wish waits."""
        return self._wishes.is_waiting

    @property
    def replaced(self) -> int:
        """How many wishes were dropped for a newer one."""
        return self._wishes.replaced

    def stop(self, timeout_s: float = 60.0) -> None:
        """Ends after the wish that is being carried out; may be called again."""
        self._wishes.close()
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def _work(self) -> None:
        is_shown = False
        while not self._wishes.is_closed:
            wish = self._wishes.take(self._session.pause_s if is_shown else None)
            if self._wishes.is_closed:
                return
            wish, is_shown = wish or self._session.now, False
            self._busy_since = time.monotonic()
            try:
                self.told("solving")
                sight = self._session.go(wish)
                self._show(sight)
                self.told("rendering")
                self._show(self._session.look(sight))
                is_shown = True
            except MagicsimError as error:
                self._failed(str(error))
            except Exception as error:
                LOGGER.exception("the live window could not go on with a request")
                self._failed(f"{type(error).__name__}: {error}")
            finally:
                self._busy_since = None
                self.told(READY)
