"""Files that are kept to be used again: where, how large all of one kind may be together, and which go first."""

import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

TAKES = Path("magicsim-takes")
"""Folder of takes, unless another is named."""
FRAMES_VARIABLE = "MAGICSIM_FRAMES"
"""Environment variable that names the folder of copies of frames."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptFiles:
    """Files of one kind in a folder, which may hold others; the one that was asked for last counts as the newest."""

    folder: Path
    pattern: str
    """Regular expression of the whole name."""
    most_bytes: int
    """Size of all of them together [bytes]; the newest stays however large it is."""

    def files(self) -> list[Path]:
        """Files that magicsim wrote there, the one that was asked for last at the end."""
        if not self.folder.is_dir():
            return []
        found = []
        for path in self.folder.iterdir():
            with suppress(FileNotFoundError):  # another process has removed it
                if re.fullmatch(self.pattern, path.name) and path.is_file():
                    found.append((path.stat().st_mtime_ns, path))
        return [path for _, path in sorted(found)]

    def size_bytes(self) -> int:
        """Size of all these files."""
        return sum(_size(path) for path in self.files())

    def clear(self) -> int:
        """Removes these files and says how many."""
        files = self.files()
        for path in files:
            path.unlink(missing_ok=True)
        return len(files)

    def touch(self, path: Path) -> None:
        """Makes a file the newest, where its folder can be written."""
        with suppress(OSError):
            os.utime(path)

    def shrink(self) -> None:
        """Removes the oldest files until what is left is small enough."""
        files = self.files()
        sizes = [_size(path) for path in files]
        while len(files) > 1 and sum(sizes) > self.most_bytes:
            files.pop(0).unlink(missing_ok=True)
            sizes.pop(0)


def kept_takes(folder: Path) -> KeptFiles:
    """Takes of a folder: 20 GB, a few hundred episodes of 60 frames of 240 x 320 pixels."""
    return KeptFiles(folder=folder, pattern=r"[0-9a-f]{24}\.npz", most_bytes=20_000_000_000)


def kept_copies(folder: Path) -> KeptFiles:
    """Mapped copies of datasets' frames in a folder: 50 GB."""
    return KeptFiles(folder=folder, pattern=r"[0-9a-f]{32}\.arrow", most_bytes=50_000_000_000)


def cache_folder() -> Path | None:
    """Folder of this user for what is kept between runs; None where there is no home folder."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    with suppress(RuntimeError):
        return Path(base).expanduser() / "magicsim"
    return None


def frames_folder() -> Path | None:
    """Folder of the copies of frames, see `FRAMES_VARIABLE`; None where there is no home folder."""
    with suppress(RuntimeError):
        return Path(os.environ.get(FRAMES_VARIABLE) or "~/.cache/magicsim/frames").expanduser()
    return None


def _size(path: Path) -> int:
    with suppress(FileNotFoundError):
        return path.stat().st_size
    return 0
