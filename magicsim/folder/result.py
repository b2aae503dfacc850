"""Folders of results that appear whole under their final name, or not at all."""

import errno
import logging
import os
import shutil
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from magicsim.errors import OutputError
from magicsim.folder.listing import LISTING, foreign_in, read_listing, remove_listed, write_listing
from magicsim.folder.lock import can_be_replaced, is_lock, sole_writer
from magicsim.folder.naming import beside, check_writable, within, working_folders
from magicsim.folder.placing import put_in_place

LOGGER = logging.getLogger(__name__)
MARKER = "config.toml"
"""File of a result that makes it again."""
SIGNATURE = "# Written by magicsim"
"""How that file begins."""
NAMED = 3
"""Foreign files that a message names."""


@contextmanager
def result_folder(target: Path) -> Iterator[Path]:
    """A folder to fill, which takes the target's place when the block ends without an error.

    An earlier result there is replaced; a list in the folder (`LISTING`) shows what magicsim wrote.

    Raises:
        OutputError: The target is a file, holds something that magicsim did not write, is being written by another
            run, or cannot be written.
    """
    with _folder(target, is_listed=True) as partial:
        yield partial


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """A folder to fill, which takes a name that nobody has, or an empty folder's, when the block ends without an error.

    Raises:
        OutputError: The target is there, is being written by another run, or cannot be written.
    """
    with _folder(target, is_listed=False) as partial:
        yield partial


@contextmanager
def _folder(target: Path, *, is_listed: bool) -> Iterator[Path]:
    check_target(target)
    with output_errors(target):
        target = Path(os.path.realpath(target))  # `.` has no name of its own
        with sole_writer(target):
            check_target(target)
            _clear_leftovers(target)
            with _working_folder(target) as partial:
                yield partial
                if is_listed:
                    write_listing(partial)
                _finish(partial, target)


@contextmanager
def output_errors(target: Path, *, then: str = "") -> Iterator[None]:
    """Turns what the system says against writing into one line.

    Args:
        target: What is written.
        then: What else to say.

    Raises:
        OutputError: Instead of any `OSError`.
    """
    try:
        yield
    except OSError as error:
        reason = "no space left on the disk" if error.errno == errno.ENOSPC else error.strerror or str(error)
        msg = f"cannot write {target}: {reason}{then}"
        raise OutputError(msg) from None


def check_target(target: Path) -> None:
    """Refuses a target that holds anything that magicsim cannot show it wrote.

    Raises:
        OutputError: The target is a file or a folder with something foreign in it, which is named, or cannot be read.
    """
    with output_errors(target):
        present = names_in(target)
        own = {path.name for path in working_folders(target)}
        present = [name for name in present if name not in own]
        listing = read_listing(target)
        if listing is None and _looks_like_a_result(target):
            msg = f"output folder '{target}' holds a result without its list '{LISTING}'; name a new or empty folder"
            raise OutputError(msg)
        if listing is None:
            refuse_others(target, present)
        foreign = [
            name for name in foreign_in(target, listing or {}) if Path(name).parts[0] not in own and not is_lock(name)
        ]
    refuse_foreign(target, foreign)
    check_place(target)


def check_place(target: Path) -> None:
    """Refuses a folder that cannot be made or written, before any work is done for it.

    Raises:
        OutputError: Something above it is a file, a name is too long, or nothing can be made there.
    """
    with output_errors(target):
        real = Path(os.path.realpath(target))  # `.` has no name of its own
        check_writable(target, beside(real, "partial") if can_be_replaced(real) else within(real, "partial"))


def refuse_foreign(target: Path, names: Sequence[str]) -> None:
    """Refuses a folder for what is in it, if there is any.

    Raises:
        OutputError: It names some of that.
    """
    if names:
        msg = f"output folder '{target}' holds {_some(names)}, not as magicsim wrote it; move that away"
        raise OutputError(msg)


def refuse_others(target: Path, names: Collection[str]) -> None:
    """Refuses a folder in which nothing is magicsim's, if it holds anything.

    Raises:
        OutputError: It names some of that.
    """
    if names:
        msg = f"output folder '{target}' holds other files ({_some(sorted(names))}); name a new or empty folder"
        raise OutputError(msg)


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(f"'{name}'" for name in names[:NAMED]) + more


def names_in(folder: Path) -> list[str]:
    """Names in an output folder but for its lock; none where there is no folder yet.

    Raises:
        OutputError: It is a file, or something above it is.
        OSError: It cannot be read, such as a loop of links.
    """
    try:
        return [name for name in os.listdir(folder) if not is_lock(name)]
    except FileNotFoundError:
        return []
    except NotADirectoryError:
        if not folder.is_file():
            check_place(folder)  # which names what is a file above it
            return []
        msg = f"output folder '{folder}' is a file; name a new folder"
        raise OutputError(msg) from None


def _looks_like_a_result(folder: Path) -> bool:
    try:
        return (folder / MARKER).read_bytes().startswith(SIGNATURE.encode())
    except OSError:
        return False


def _clear_leftovers(target: Path) -> None:
    """Puts back or removes what killed runs for this target have left; what has no list yet is told."""
    for path in working_folders(target):
        if ".old" in path.name and not target.exists():
            path.rename(target)
        elif remove_listed(path):
            LOGGER.warning("'%s' was left by a run that was killed; nothing needs it", path)


@contextmanager
def _working_folder(target: Path) -> Iterator[Path]:
    """An empty folder that is made before any work, beside the target or, where that cannot be, in it."""
    folder = beside(target, "partial") if can_be_replaced(target) else within(target, "partial")
    folder.mkdir(parents=True)
    try:
        yield folder
    except _NotPlacedError:
        raise
    except BaseException:
        with suppress(OSError):
            shutil.rmtree(folder)
        raise


class _NotPlacedError(OutputError):
    """The result is whole, but not under its name."""


def _finish(partial: Path, target: Path) -> None:
    try:
        put_in_place(partial, target)
    except OSError as error:
        msg = f"cannot write {target}: {error.strerror or error}; the result is whole in '{partial}'"
        raise _NotPlacedError(msg) from None
