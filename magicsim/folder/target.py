"""Where results go: names of what is not whole yet, and what stands in the way, told before any work is done.

One writer at a time for a folder of results, whatever command it is and however it ends.
"""

import errno
import os
import re
import secrets
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from magicsim.errors import OutputError
from magicsim.folder.listing import LISTING, foreign_in, read_listing

LOCK = "magicsim-lock"
"""How the lock's file ends, beside the folder, or its whole name in it where nothing can be made beside."""


@contextmanager
def sole_writer(target: Path) -> Iterator[None]:
    """Keeps other runs from writing a folder (`OutputError`); ends with the process, however that ends.

    The file goes as the very last thing while the lock is held. Who waits for it then locks a file without a name,
    which `filelock` notices, and begins anew.
    """
    real = Path(os.path.realpath(target))  # `.` has no name of its own
    path = real.with_name(f".{real.name}.{LOCK}") if can_be_replaced(real) else real / f".{LOCK}"
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


MARKER = "config.toml"
"""File of a result that makes it again."""
SIGNATURE = "# Written by magicsim"
"""How that file begins."""
QUOTED = 3
"""Foreign files that a message names."""
_TOKEN_BYTES = 8
_TOKEN = f"[0-9a-f]{{{2 * _TOKEN_BYTES}}}"


def new_token() -> str:
    """Sixteen random hexadecimal digits, for a name that nobody else uses."""
    return secrets.token_hex(_TOKEN_BYTES)


def beside(target: Path, purpose: str) -> Path:
    """A new hidden name next to a file or folder, such as `.out.TOKEN.partial`; a file keeps its ending."""
    return target.with_name(f".{target.stem}.{new_token()}.{purpose}{target.suffix}")


def within(folder: Path, purpose: str) -> Path:
    """A new hidden name in a folder."""
    return folder / f".{new_token()}.{purpose}"


def working_place(target: Path) -> Path:
    """A new name for what becomes a folder: beside it or, where nothing can be renamed there, in it."""
    return beside(target, "partial") if can_be_replaced(target) else within(target, "partial")


def is_working_name(name: str) -> bool:
    """Whether a name is one of those that `beside` and `within` make."""
    return re.fullmatch(rf"\.(.*\.)?{_TOKEN}\.[a-z]+(\..*)?", name, re.DOTALL) is not None


def working_folders(target: Path) -> list[Path]:
    """Folders that runs for this target have made beside it and in it."""
    beside_it = rf"\.{re.escape(target.stem)}\.{_TOKEN}\.[a-z]+{re.escape(target.suffix)}"
    return [
        path
        for place, pattern in ((target.parent, beside_it), (target, rf"\.{_TOKEN}\.[a-z]+"))
        if place.is_dir()
        for path in sorted(place.iterdir())
        if re.fullmatch(pattern, path.name) and path.is_dir() and not path.is_symlink()
    ]


@contextmanager
def output_errors(target: Path, *, then: str = "") -> Iterator[None]:
    """Turns what the system says against writing a target into an `OutputError` of one line, which ends with `then`."""
    try:
        yield
    except OSError as error:
        reason = "no space left on the disk" if error.errno == errno.ENOSPC else error.strerror or str(error)
        raise OutputError(f"cannot write {target}: {reason}{then}") from None
    except UnicodeEncodeError as error:  # of the name: what is written is UTF-8
        raise OutputError(f"cannot write {target}: no name in {error.encoding}{then}") from None


def check_target(target: Path) -> None:
    """Refuses (`OutputError`) a target that is a file, or holds anything that magicsim cannot show it wrote."""
    with output_errors(target):
        own = {path.name for path in working_folders(target)}
        present = [name for name in names_in(target) if name not in own]
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


def check_current_folder() -> None:
    """Refuses (`OutputError`) a current folder that is gone, where the renderer and MKL would end the process."""
    try:
        os.getcwd()
    except OSError:
        raise OutputError("the current folder is gone: change to one that is there") from None


def check_place(target: Path) -> None:
    """Refuses (`OutputError`) a folder that cannot be made or written, before any work is done for it."""
    with output_errors(target):
        check_writable(target, working_place(Path(os.path.realpath(target))))  # `.` has no name of its own


def check_writable(target: Path, working: Path) -> None:
    """Refuses a place where nothing can be made; a folder is made there for a moment, and nothing stays.

    `working` is what will be made first, beside the target or in it. `OutputError` where something above it is a file
    or may not be written, other errors as the system has them of names.
    """
    str(working).encode()  # bytes that are no text, which many libraries refuse
    place, missing = working.parent, [working.name]
    while not os.path.lexists(place):
        missing.append(place.name)
        place = place.parent
    os.stat(place)  # links in a circle, or to nothing
    if not place.is_dir():
        raise OutputError(f"cannot write {target}: '{place}' is not a folder")
    for name in missing:
        with suppress(FileNotFoundError):
            os.lstat(place / name)  # names that are too long
    if not os.access(place, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write {target}: '{place}' cannot be written")
    trial = within(place, "partial")
    trial.mkdir()
    trial.rmdir()


def names_in(folder: Path) -> list[str]:
    """Names in an output folder but for its lock; none where there is no folder yet.

    `OutputError` where it is a file, or something above it is; `OSError` where it cannot be read.
    """
    try:
        return [name for name in os.listdir(folder) if not is_lock(name)]
    except FileNotFoundError:
        return []
    except NotADirectoryError:
        if not folder.is_file():
            check_place(folder)  # which names what is a file above it
            return []
        raise OutputError(f"output folder '{folder}' is a file; name a new folder") from None


def refuse_foreign(target: Path, names: Sequence[str]) -> None:
    """Refuses a folder for what is in it, if there is any: the `OutputError` names some of that."""
    if names:
        raise OutputError(f"output folder '{target}' holds {_some(names)}, not as magicsim wrote it; move that away")


def refuse_others(target: Path, names: Collection[str]) -> None:
    """Refuses a folder in which nothing is magicsim's, if it holds anything: the `OutputError` names some of that."""
    if names:
        msg = f"output folder '{target}' holds other files ({_some(sorted(names))}); name a new or empty folder"
        raise OutputError(msg)


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - QUOTED} more" if len(names) > QUOTED else ""
    return ", ".join(f"'{name}'" for name in names[:QUOTED]) + more


def _looks_like_a_result(folder: Path) -> bool:
    try:
        return (folder / MARKER).read_bytes().startswith(SIGNATURE.encode())
    except OSError:
        return False
