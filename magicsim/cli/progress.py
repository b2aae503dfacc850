"""Progress of long work on stderr: a bar with an estimate on a terminal, plain lines elsewhere."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from magicsim.errors import one_line
from magicsim.waiting import shown_elsewhere

TITLE_LENGTH = 120
"""Longest title [characters]."""
LINE_SECONDS = 10.0
"""Shortest time between two plain lines [s]."""
FORETOLD = 0.01
"""Share of the work from which plain lines estimate the time of the rest."""


@contextmanager
def show_progress(title: str) -> Iterator[Callable[..., None]]:
    """Gives a function that takes the work done and all work, in any unit, and a note if there is one.

    What else would say that it takes long is silent within (`magicsim.waiting`).
    """
    title = one_line(title, TITLE_LENGTH)
    console = Console(stderr=True)
    if not console.is_terminal:
        with _plain_lines(title) as report, shown_elsewhere():
            yield report
        return
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(),
        TimeElapsedColumn(), TimeRemainingColumn(),
        TextColumn("{task.fields[note]}", markup=False),
    )  # fmt: skip
    with Progress(*columns, console=console) as bar, shown_elsewhere():
        task = bar.add_task(title, total=None, note="")
        yield lambda done, total, note="": bar.update(task, completed=done, total=total, note=note)


@contextmanager
def _plain_lines(title: str) -> Iterator[Callable[..., None]]:
    """Lines with the part that is done, and where a part takes long, lines that say only that work goes on.

    A note about work of which nothing is done yet names what is begun, and is a line at once.
    """
    start = last = time.monotonic()
    ended, phase = threading.Event(), ""

    def report(done: int, total: int, note: str = "") -> None:
        nonlocal last, phase
        now = time.monotonic()
        is_begun, phase = done == 0 and bool(note) and note != phase, note
        if now - last < LINE_SECONDS and done < total and not is_begun:
            return
        last = now
        left = f", about {(now - start) / done * (total - done):.0f} s left" if done >= FORETOLD * total else ""
        more = f", {note}" if note else ""
        sys.stderr.write(f"{title}: {done / total:.0%}, {now - start:.0f} s so far{left}{more}\n")

    def go_on() -> None:
        nonlocal last
        while not ended.wait(LINE_SECONDS / 5):
            now = time.monotonic()
            if now - last >= LINE_SECONDS:
                last = now
                sys.stderr.write(f"{title}: {now - start:.0f} s so far{f', {phase}' if phase else ''}\n")

    threading.Thread(target=go_on, daemon=True).start()
    try:
        yield report
    finally:
        ended.set()
