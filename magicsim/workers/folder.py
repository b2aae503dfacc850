"""What folders of results share that grow over several runs: one writer, files that are whole or not there, a log."""

import errno
import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from magicsim.errors import OutputError
from magicsim.workers.outcome import Failure

WORK = ".work"
"""Folder of what is not yet in its final place; gone when the run is complete."""
ERRORS = "errors.jsonl"
"""One line for each failed attempt, with its traceback."""


@contextmanager
def sole_writer(out: Path) -> Iterator[None]:
    """Keeps other runs out of the folder; ends with the process, however that ends.

    Raises:
        OutputError: Another run writes there, or the folder cannot be written.
    """
    try:
        with _lock(out):
            yield
    except OSError as error:
        reason = "no space left on the disk" if error.errno == errno.ENOSPC else error.strerror or str(error)
        msg = f"cannot write {out}: {reason}; what is finished is kept, and --resume goes on from there"
        raise OutputError(msg) from None


@contextmanager
def _lock(out: Path) -> Iterator[None]:
    work = out / WORK
    work.mkdir(parents=True, exist_ok=True)
    with (work / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            msg = f"output folder '{out}' is being written by another run"
            raise OutputError(msg) from None
        try:
            yield
        finally:
            (work / "lock").unlink(missing_ok=True)
            with suppress(OSError):  # not empty, or gone
                work.rmdir()


def log_failures(out: Path, unit: str, number: int, failures: tuple[Failure, ...]) -> None:
    """Adds the failed attempts at one unit of work, such as an episode, to the error log, by its number."""
    if not failures:
        return
    lines = [
        json.dumps({unit: number, "kind": str(each.kind), "message": each.message, "traceback": each.traceback})
        for each in failures
    ]
    with (out / ERRORS).open("a", encoding="utf-8") as log:
        log.write("".join(f"{line}\n" for line in lines))
        log.flush()
        os.fsync(log.fileno())


def place(path: Path, content: bytes) -> None:
    """Gives a file its content under its final name, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.tmp")
    with partial.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    settle_name(partial, path)


def settle_name(partial: Path, path: Path) -> None:
    """Renames a file that is already on disk, and makes the name last."""
    partial.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
