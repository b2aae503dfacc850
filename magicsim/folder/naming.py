"""Names of what is not whole yet: hidden, beside the place it is made for, with a part that nobody else has."""

import re
import secrets
from pathlib import Path

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
