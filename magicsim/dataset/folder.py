"""The folder that a dataset grows in: what it may hold before, and episodes that wait for their shard."""

import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.manifest import MANIFEST, Manifest, read_manifest
from magicsim.dataset.shard import read_rows
from magicsim.errors import OutputError
from magicsim.workers.folder import ERRORS, WORK, place

PREVIEW_FILES = frozenset({"preview.png", "preview.json"})


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a dataset that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    if out.exists() and not out.is_dir():
        msg = f"output folder '{out}' is a file; name a new folder"
        raise OutputError(msg)
    names = {path.name for path in out.iterdir()} - PREVIEW_FILES if out.is_dir() else set()
    manifest = begun_dataset(out)
    if manifest is None and not (out / MANIFEST).is_file() and names - {WORK, ERRORS}:
        msg = f"output folder '{out}' holds other files; name a new or empty folder"
        raise OutputError(msg)
    if manifest is not None and not resume:
        state = "a" if manifest.is_complete else "an unfinished"
        msg = f"output folder '{out}' holds {state} dataset already; --resume goes on with it"
        raise OutputError(msg)


def begun_dataset(out: Path) -> Manifest | None:
    """Manifest of the dataset in a folder; None also where nothing of it was ever finished, so that nothing is lost.

    Raises:
        OutputError: There is a manifest that this version does not understand.
    """
    manifest = read_manifest(out)
    if manifest is None or manifest.shards or manifest.failed or any((out / WORK).glob("episode-*.parquet")):
        return manifest
    return None


class Staging:
    """Finished episodes on disk, each whole or not there."""

    def __init__(self, out: Path) -> None:
        """Looks at what is there, and drops what no longer reads."""
        self._folder = out / WORK
        for path in self._folder.glob("episode-*.parquet"):
            try:
                pq.read_metadata(path)
            except (pa.ArrowException, OSError):
                path.unlink()

    def episodes(self) -> set[int]:
        """Numbers of the episodes that wait."""
        return {int(path.stem.partition("-")[2]) for path in self._folder.glob("episode-*.parquet")}

    def put(self, episode: int, content: bytes) -> None:
        """Takes a finished episode."""
        place(self._path(episode), content)

    def table(self, episode: int) -> pa.Table:
        """Rows of an episode."""
        return read_rows(self._path(episode))

    def drop(self, episodes: tuple[int, ...]) -> None:
        """Forgets episodes that are in a finished shard."""
        for episode in episodes:
            self._path(episode).unlink(missing_ok=True)

    def close(self) -> None:
        """Removes everything, once the dataset is complete."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _path(self, episode: int) -> Path:
        return self._folder / f"episode-{episode:08d}.parquet"
