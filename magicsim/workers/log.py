"""The log of failed attempts in a folder that grows over several runs: one line each, which tells if it has changed."""

import os
from pathlib import Path

from magicsim.folder.sealing import is_sealed, sealed
from magicsim.workers.outcome import Failure

ERRORS = "errors.jsonl"
"""One line for each failed attempt, with its traceback."""


def log_failures(out: Path, unit: str, number: int, failures: tuple[Failure, ...]) -> None:
    """Adds the failed attempts at one unit of work, such as an episode, to the error log, by its number."""
    if not failures:
        return
    lines = [
        sealed(
            {unit: number, "kind": str(each.kind), "message": each.message, "traceback": each.traceback}, indent=None
        )
        for each in failures
    ]
    with (out / ERRORS).open("ab") as log:
        log.write(b"".join(lines))
        log.flush()
        os.fsync(log.fileno())


def changed_lines(out: Path) -> list[int]:
    """Numbers, from 1, of the lines of a folder's error log that are not as they were written; none without a log."""
    path = out / ERRORS
    lines = path.read_bytes().splitlines(keepends=True) if path.is_file() else []
    return [number for number, line in enumerate(lines, 1) if not is_sealed(line, indent=None)]
