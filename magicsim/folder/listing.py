"""Lists of files with their size and hash: what magicsim wrote into a finished folder, and JSON that hashes itself."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


LISTING = ".magicsim.json"
"""Name of the list, which does not list itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """What a file was when it was written."""

    sha256: str
    size: int | None = None
    """Length [bytes]; None where only the hash is listed."""

    def is_unchanged(self, path: Path) -> bool:
        """Whether the file at a path is still this one; a link never is."""
        is_file = path.is_file() and not path.is_symlink()
        return is_file and self.size in {None, path.stat().st_size} and sha256_of(path) == self.sha256


def write_listing(folder: Path) -> None:
    """Lists every file that a folder holds now."""
    files = {
        name: {"size": (folder / name).stat().st_size, "sha256": sha256_of(folder / name)}
        for name in files_below(folder)
    }
    content = {"written_by": "magicsim", "files": files}
    (folder / LISTING).write_text(json.dumps(content, indent=0) + "\n", encoding="utf-8")


def read_listing(folder: Path) -> dict[str, Listed] | None:
    """The list of a folder by name below it; None where there is none that can be read."""
    try:
        files = json.loads((folder / LISTING).read_text(encoding="utf-8"))["files"]
        return {str(name): Listed(size=int(each["size"]), sha256=str(each["sha256"])) for name, each in files.items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def foreign_in(folder: Path, listing: Mapping[str, Listed]) -> Iterator[str]:
    """Names below a folder of what its list does not show to be magicsim's: other or changed files, other folders."""
    known_folders = {str(parent) for name in listing for parent in Path(name).parents}
    for name in sorted(everything_below(folder)):
        path = folder / name
        if path.is_dir() and not path.is_symlink():
            if name not in known_folders:
                yield name
        elif name != LISTING and not (name in listing and listing[name].is_unchanged(path)):
            yield name


def remove_listed(folder: Path) -> list[str]:
    """Removes what a folder's list shows to be magicsim's, the list, and empty folders; returns what is left."""
    listing = read_listing(folder) or {}
    foreign = set(foreign_in(folder, listing))
    for name in listing:
        if name not in foreign:
            (folder / name).unlink(missing_ok=True)
    if listing:
        (folder / LISTING).unlink()
    remove_empty_folders(folder)
    return sorted(everything_below(folder)) if folder.exists() else []


def remove_empty_folders(folder: Path) -> None:
    """Removes a folder and those below it, as far as they hold no file."""
    for path, _, _ in os.walk(folder, topdown=False):
        with suppress(OSError):  # it holds something
            Path(path).rmdir()


def everything_below(folder: Path) -> Iterator[str]:
    """Names below a folder of all files, links and folders in it; links are not followed."""
    for path, folders, files in os.walk(folder):
        for name in (*folders, *files):
            yield (Path(path) / name).relative_to(folder).as_posix()


def files_below(folder: Path) -> list[str]:
    """Names below a folder of all files and links in it, in order."""
    paths = ((name, folder / name) for name in everything_below(folder))
    return sorted(name for name, path in paths if path.is_symlink() or not path.is_dir())


SEAL = "sha256"
"""Key of the hash, the last one."""


def sealed(values: Mapping[str, Any], *, indent: int | None = 1) -> bytes:
    """An object as JSON that ends with a newline, with the SHA-256 of the text in which that key is empty.

    An `indent` of None gives one line.
    """
    plain = {key: value for key, value in values.items() if key != SEAL}
    digest = hashlib.sha256(_text(plain | {SEAL: ""}, indent)).hexdigest()
    return _text(plain | {SEAL: digest}, indent)


def is_sealed(text: bytes, *, indent: int | None = 1) -> bool:
    """Whether a text is byte for byte what `sealed` makes of its content."""
    try:
        values = json.loads(text)
        return isinstance(values, dict) and sealed(values, indent=indent) == text
    except (ValueError, RecursionError):
        return False


def _text(values: Mapping[str, Any], indent: int | None) -> bytes:
    return (json.dumps(values, indent=indent) + "\n").encode()
