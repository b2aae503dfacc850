"""A word about what takes long: whoever waits more than two seconds hears what for."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Told = Callable[[str], None]
"""Takes one line about what is being done."""
FIRST_S, NEXT_S = 2.0, 5.0
"""When the first line comes, and the time from one line to the next [s]."""


def on_stderr(line: str) -> None:
    """Writes a line to stderr."""
    sys.stderr.write(f"magicsim: {line}\n")


@contextmanager
def waiting(what: str, told: Told) -> Iterator[None]:
    """Within it, a line comes after two seconds and every five from then on; none where the block ends before.

    Args:
        what: What is being done.
        told: Takes the lines, on a thread of its own.
    """
    ended, start = threading.Event(), time.monotonic()

    def watch() -> None:
        pause = FIRST_S
        while not ended.wait(pause):
            told(f"{what}, {time.monotonic() - start:.0f} s so far")
            pause = NEXT_S

    watching = threading.Thread(target=watch, name="magicsim-waiting", daemon=True)
    watching.start()
    try:
        yield
    finally:
        ended.set()
        watching.join()
