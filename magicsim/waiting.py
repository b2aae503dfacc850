"""A word about what takes long: whoever waits more than two seconds hears what for."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Told = Callable[[str], None]
"""Takes one line about what is being done."""
FIRST_S, NEXT_S = 2.0, 5.0
"""When the first line comes, and the time from one line to the next [s]."""


def on_stderr(line: str) -> None:
    """Writes a line to stderr."""
    sys.stderr.write(f"magicsim: {line}\n")


def unheard(line: str) -> None:
    """Drops a line: as `told`, it makes a wait silent."""


class _Stage:
    """One wait among those that are inside each other."""

    def __init__(self, what: str) -> None:
        self.what, self.share = what, ""

    def reach(self, done: float, total: float, *_: object) -> None:
        """Takes the work done and all work, in any unit, for the lines to come."""
        self.share = f" ({done / total:.0%})" if total > 0 else ""

    def __str__(self) -> str:
        return f"{self.what}{self.share}"


_stages: ContextVar[list[_Stage] | None] = ContextVar("stages", default=None)
"""Waits that go on here, the outermost first; None outside of any."""


@contextmanager
def waiting(what: str, told: Told = on_stderr) -> Iterator[Callable[..., None]]:
    """Within it, a line comes after two seconds and every five from then on; none where the block ends before.

    Args:
        what: What is being done.
        told: Takes the lines, on a thread of its own; inside another wait nothing, since that one speaks for both.

    Yields:
        Takes the work done and all work, in any unit, and tells the share in the lines to come.
    """
    stage, outer = _Stage(what), _stages.get()
    if outer is not None:
        outer.append(stage)
        try:
            yield stage.reach
        finally:
            outer.remove(stage)
        return
    ended, start, stages = threading.Event(), time.monotonic(), [stage]

    def watch() -> None:
        pause = FIRST_S
        while not ended.wait(pause):
            told(f"{_described(stages)}, {time.monotonic() - start:.0f} s so far")
            pause = NEXT_S

    watching = threading.Thread(target=watch, name="magicsim-waiting", daemon=True)
    token = _stages.set(stages)
    watching.start()
    try:
        yield stage.reach
    finally:
        _stages.reset(token)
        ended.set()
        watching.join()


@contextmanager
def shown_elsewhere() -> Iterator[None]:
    """Within it no wait says anything: something else shows how far the work is, such as a progress bar."""
    token = _stages.set([])
    try:
        yield
    finally:
        _stages.reset(token)


def _described(stages: list[_Stage]) -> str:
    """The outermost and the innermost of the waits that go on."""
    seen = [*stages]  # another thread goes on meanwhile
    return ": ".join(map(str, [seen[0], *seen[1:][-1:]]))
