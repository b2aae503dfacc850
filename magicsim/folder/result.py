"""Folders and files of results that appear whole under their final name, or not at all."""

import logging
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from magicsim.errors import OutputError
from magicsim.folder.listing import remove_empty_folders, remove_listed, write_listing
from magicsim.folder.target import (
    beside,
    check_target,
    check_writable,
    is_lock,
    is_working_name,
    new_token,
    output_errors,
    sole_writer,
    within,
    working_folders,
    working_place,
)

LOGGER = logging.getLogger(__name__)
PRODUCER = "magicsim"
"""What a picture or a mesh says made it."""
SIGNED_BYTES = 4096
"""Where that stands in the file, at the latest."""


class _NotPlacedError(OutputError):
    """The result is whole, but not under its name."""


@contextmanager
def result_folder(target: Path, *, is_listed: bool = True) -> Iterator[Path]:
    """A folder to fill, which takes the target's place when the block ends without an error.

    An earlier result there is replaced; a list in the folder (`LISTING`) shows what magicsim wrote. Without that list
    it is for a name that nobody has, or an empty folder.

    Raises:
        OutputError: The target is a file, holds something that magicsim did not write, is being written by another
            run, or cannot be written.
    """
    check_target(target)
    with output_errors(target):
        target = Path(os.path.realpath(target))  # `.` has no name of its own
        with sole_writer(target):
            check_target(target)
            _clear_leftovers(target)
            partial = working_place(target)
            partial.mkdir(parents=True)
            try:
                yield partial
                if is_listed:
                    write_listing(partial)
                _put_in_place(partial, target)
            except _NotPlacedError:
                raise
            except BaseException:
                shutil.rmtree(partial, ignore_errors=True)
                raise


def _clear_leftovers(target: Path) -> None:
    """Puts back or removes what killed runs for this target have left, and names what has no list yet."""
    for path in working_folders(target):
        if path.name.removesuffix(target.suffix).endswith(".old") and not target.exists():
            path.rename(target)
        elif remove_listed(path):
            LOGGER.warning("'%s' was left by a run that was killed; nothing needs it", path)


def _put_in_place(new: Path, target: Path) -> None:
    """Gives a finished folder its name, and then removes what stood there, as far as magicsim wrote it.

    A folder that cannot be renamed, such as a mount point, exchanges its content. Where that fails too, the old folder
    stands as before, and the `OutputError` says where the new one is.
    """
    try:
        if new.parent == target:
            _exchange_content(new, target)
        elif not _is_renamed(new, target):
            copy = within(target, "partial")  # perhaps on another disk: what takes time comes before the exchange
            try:
                shutil.copytree(new, copy)
                _exchange_content(copy, target)
            except OSError:
                shutil.rmtree(copy, ignore_errors=True)
                raise
            shutil.rmtree(new)
    except OSError as error:
        msg = f"cannot write {target}: {error.strerror or error}; the result is whole in '{new}'"
        raise _NotPlacedError(msg) from None


def _is_renamed(new: Path, target: Path) -> bool:
    """Renames a folder, and where there is one before that one; whether that could be done."""
    if not target.exists():
        new.rename(target)
        return True
    old = beside(target, "old")
    try:
        target.rename(old)
    except OSError:
        return False
    try:
        new.rename(target)
    except OSError:
        old.rename(target)
        raise
    _clear(old, target.with_name(f"{target.name}.kept-{new_token()}"))
    return True


def _exchange_content(new: Path, target: Path) -> None:
    """Moves what a folder holds out of the way, the content of another in it to its place, and then the old away."""
    old = within(target, "old")
    old.mkdir()
    moved: list[tuple[Path, Path]] = []
    try:
        before = [path for path in target.iterdir() if not is_lock(path.name) and not is_working_name(path.name)]
        for path, place in [*((path, old) for path in before), *((path, target) for path in list(new.iterdir()))]:
            moved.append((path, path.rename(place / path.name)))
    except OSError:
        for path, now in reversed(moved):
            now.rename(path)
        old.rmdir()
        raise
    new.rmdir()
    _clear(old, target / f"kept-{new_token()}")


def _clear(old: Path, refuge: Path) -> None:
    """Removes an earlier result; what somebody put into it meanwhile gets a visible name."""
    with suppress(OSError):
        if remove_listed(old):
            old.rename(refuge)
            LOGGER.warning("what magicsim did not write in the earlier result is kept in '%s'", refuge)
        remove_empty_folders(old)


@contextmanager
def result_file(target: Path) -> Iterator[Path]:
    """A file to write beside the target, which takes its place when the block ends without an error."""
    check_file(target)
    with output_errors(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        partial = beside(target, "partial")
        try:
            yield partial
            partial.replace(target)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)


def check_file(target: Path) -> None:
    """Refuses (`OutputError`) a file that is a folder or cannot be written, before any work is done for it."""
    with output_errors(target):
        if target.is_dir():
            raise OutputError(f"output file '{target}' is a folder; name a file")
        check_writable(target, beside(target, "partial"))


def refuse_unsigned(target: Path) -> None:
    """Refuses (`OutputError`) to replace a file that nobody named, but for one that begins as magicsim's do."""
    with output_errors(target):
        if not target.is_file():
            return
        with target.open("rb") as file:
            if PRODUCER.encode() in file.read(SIGNED_BYTES):
                return
        msg = f"'{target}' would be replaced, and magicsim did not write it; move it away, or name another output"
        raise OutputError(msg)
