"""Whether a place can be written, tried before any work is done for it."""

import os
from contextlib import suppress
from pathlib import Path

from magicsim.errors import OutputError
from magicsim.folder.naming import within


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
