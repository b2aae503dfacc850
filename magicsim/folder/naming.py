"""Names of what is not whole yet: hidden, beside the place it is made for, with a part that nobody else has."""

import os
import re
import secrets
from contextlib import suppress
from pathlib import Path

from magicsim.errors import OutputError

_TOKEN_BYTES = 8
_TOKEN = f"[0-9a-f]{{{2 * _TOKEN_BYTES}}}"


def new_token() -> str:
    """Sixteen random hexadecimal digits."""
    return secrets.token_hex(_TOKEN_BYTES)


def beside(target: Path, purpose: str) -> Path:
    """A new name next to a file or folder; a file keeps its ending, from which programs tell the format.

    Args:
        target: Where the content will stand.
        purpose: What it is meanwhile, such as `partial`.
    """
    return target.with_name(f".{target.stem}.{new_token()}.{purpose}{target.suffix}")


def within(folder: Path, purpose: str) -> Path:
    """A new name in a folder."""
    return folder / f".{new_token()}.{purpose}"


def is_working_name(name: str) -> bool:
    """Whether a name is one of those that `beside` and `within` make."""
    return re.fullmatch(rf"\.(.*\.)?{_TOKEN}\.[a-z]+(\..*)?", name, re.DOTALL) is not None


def working_folders(target: Path) -> list[Path]:
    """Folders that runs for this target have made beside it and in it."""
    mark = re.compile(rf"\.{re.escape(target.stem)}\.{_TOKEN}\.[a-z]+{re.escape(target.suffix)}")
    own = re.compile(rf"\.{_TOKEN}\.[a-z]+")
    places = ((target.parent, mark), (target, own))
    return [
        path
        for place, pattern in places
        if place.is_dir()
        for path in sorted(place.iterdir())
        if pattern.fullmatch(path.name) and path.is_dir() and not path.is_symlink()
    ]


def check_writable(target: Path, working: Path) -> None:
    """Refuses a place where nothing can be made; a folder is made there for a moment, and nothing stays.

    Args:
        target: File or folder that will stand there in the end.
        working: What will be made first: beside the target, in it, or itself; its folders may be missing.

    Raises:
        OutputError: Something above the target is a file, or a folder that may not be written.
        OSError: A name is too long, leads through links in a circle, or nothing can be made there.
    """
    place, missing = working.parent, [working.name]
    while not os.path.lexists(place):
        missing.append(place.name)
        place = place.parent
    os.stat(place)  # links in a circle, or to nothing
    if not place.is_dir():
        msg = f"cannot write {target}: '{place}' is not a folder"
        raise OutputError(msg)
    for path in (working, *(place / name for name in missing)):
        with suppress(FileNotFoundError):
            os.lstat(path)  # names that are too long
    if not os.access(place, os.W_OK | os.X_OK):
        msg = f"cannot write {target}: '{place}' cannot be written"
        raise OutputError(msg)
    trial = within(place, "partial")
    trial.mkdir()
    trial.rmdir()
