"""Gives a finished folder its name: the new one stands before the old one goes."""

import logging
import shutil
from contextlib import suppress
from pathlib import Path

from magicsim.folder.listing import remove_empty_folders, remove_listed
from magicsim.folder.lock import is_lock
from magicsim.folder.naming import beside, is_working_name, new_token, within

LOGGER = logging.getLogger(__name__)


def put_in_place(new: Path, target: Path) -> None:
    """Moves a finished folder to its final name, and then removes what stood there, as far as magicsim wrote it.

    Where the folder cannot be renamed, such as a mount point, its content is exchanged within it.

    Args:
        new: The finished folder, beside the target or in it.
        target: The final name; what stands there has a list (`listing`).

    Raises:
        OSError: It cannot; the old folder stands as before, and the new one where it was.
    """
    if new.parent == target:
        _exchange_content(new, target)
        return
    if not target.exists():
        new.rename(target)
        return
    aside = beside(target, "old")
    try:
        target.rename(aside)
    except OSError:
        _exchange_content(new, target)
        return
    try:
        new.rename(target)
    except OSError:
        aside.rename(target)
        raise
    _clear(aside, target.with_name(f"{target.name}.kept-{new_token()}"))


def _exchange_content(new: Path, target: Path) -> None:
    """Moves the content of a folder into another, and what that held before out of the way and then away."""
    fresh = new
    if new.parent != target:  # perhaps on another disk: what takes time comes first
        fresh = within(target, "partial")
        try:
            shutil.copytree(new, fresh)
        except OSError:
            shutil.rmtree(fresh, ignore_errors=True)
            raise
    aside = within(target, "old")
    aside.mkdir()
    moved: list[tuple[Path, Path]] = []
    try:
        for path in [each for each in target.iterdir() if not is_lock(each.name) and not is_working_name(each.name)]:
            _move(path, aside, moved)
        for path in list(fresh.iterdir()):
            _move(path, target, moved)
    except OSError:
        for before, now in reversed(moved):
            now.rename(before)
        aside.rmdir()
        if fresh != new:
            shutil.rmtree(fresh)
        raise
    fresh.rmdir()
    if fresh != new:
        shutil.rmtree(new)
    _clear(aside, target / f"kept-{new_token()}")


def _move(path: Path, folder: Path, moved: list[tuple[Path, Path]]) -> None:
    """Moves a file or folder into a folder, and notes where it was and is."""
    moved.append((path, path.rename(folder / path.name)))


def _clear(old: Path, refuge: Path) -> None:
    """Removes an earlier result; what somebody put into it meanwhile gets a visible name."""
    with suppress(OSError):
        if remove_listed(old):
            old.rename(refuge)
            LOGGER.warning("what magicsim did not write in the earlier result is kept in '%s'", refuge)
        remove_empty_folders(old)
