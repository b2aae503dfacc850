"""Writes results to disk so that nothing half-written ever stands under a final name."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from magicsim.errors import OutputError

MARKER = "config.toml"
"""File that tells a folder of results, which may be replaced, from anybody else's folder."""
SIGNATURE = "# Written by magicsim"
"""How that file begins: many a folder holds a `config.toml` of its own."""


@contextmanager
def result_folder(target: Path) -> Iterator[Path]:
    """A folder beside the target that takes the target's place when the block ends without an error.

    Raises:
        OutputError: The target is a file, somebody else's folder, or cannot be written.
    """
    check_target(target)
    with finished_folder(target) as partial:
        yield partial


@contextmanager
def finished_folder(target: Path) -> Iterator[Path]:
    """A folder beside the target that takes the place of whatever the target holds, once it is whole.

    Raises:
        OutputError: The target cannot be written.
    """
    target = target.resolve()  # `.` has no name of its own
    partial = target.with_name(f".{target.name}.partial")
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        yield partial
        if target.exists():
            shutil.rmtree(target)
        partial.rename(target)
    except OSError as error:
        msg = f"cannot write {target}: {error.strerror or error}"
        raise OutputError(msg) from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def check_target(target: Path) -> None:
    """Refuses a target that holds something other than earlier results.

    Raises:
        OutputError: The target is a file or a folder that magicsim did not write.
    """
    if target.is_file():
        msg = f"output folder '{target}' is a file; name a new folder"
        raise OutputError(msg)
    if target.is_dir() and any(target.iterdir()) and not _is_result(target):
        msg = f"output folder '{target}' holds other files; name a new or empty folder"
        raise OutputError(msg)


def _is_result(folder: Path) -> bool:
    try:
        return (folder / MARKER).read_bytes().startswith(SIGNATURE.encode())
    except OSError:
        return False


@contextmanager
def result_file(target: Path) -> Iterator[Path]:
    """A file beside the target that takes its place when the block ends without an error.

    Raises:
        OutputError: The target is a folder or cannot be written.
    """
    if target.is_dir():
        msg = f"output file '{target}' is a folder; name a file"
        raise OutputError(msg)
    partial = target.with_name(f".{target.stem}.partial{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        partial.replace(target)
    except OSError as error:
        msg = f"cannot write {target}: {error.strerror or error}"
        raise OutputError(msg) from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
