"""One writer at a time for a folder of results, whatever command it is and however it ends."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from magicsim.errors import OutputError

LOCK = "magicsim-lock"
"""How the lock's file ends, beside the folder, or its whole name in it where nothing can be made beside."""


@contextmanager
def sole_writer(target: Path) -> Iterator[None]:
    """Keeps other runs from writing a folder (`OutputError`); ends with the process, however that ends.

    The file goes as the very last thing while the lock is held. Who waits for it then locks a file without a name,
    which `filelock` notices, and begins anew.
    """
    path = _lock_path(Path(os.path.realpath(target)))  # `.` has no name of its own
    path.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path, blocking=False)
    try:
        lock.acquire()
    except Timeout:
        raise OutputError(f"output folder '{target}' is being written by another run") from None
    try:
        yield
    finally:
        if path.is_file() and path.stat().st_size == 0:
            with suppress(PermissionError):  # Windows keeps files that are open
                path.unlink(missing_ok=True)
        lock.release()


def is_lock(name: str) -> bool:
    """Whether a name in a folder is that of the folder's own lock."""
    return name == f".{LOCK}"


def can_be_replaced(target: Path) -> bool:
    """Whether a folder can be renamed: it is no mount point, and names can be made beside it."""
    return not os.path.ismount(target) and (not target.parent.is_dir() or os.access(target.parent, os.W_OK | os.X_OK))


def _lock_path(target: Path) -> Path:
    return target.with_name(f".{target.name}.{LOCK}") if can_be_replaced(target) else target / f".{LOCK}"
