"""The folder that a dataset grows in: who may write to it, episodes that wait for their shard, the error log."""

import fcntl
import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.manifest import MANIFEST, Manifest, read_manifest
from magicsim.dataset.shard import place, read_rows
from magicsim.errors import OutputError
from magicsim.workers.outcome import Failure

WORK = ".work"
"""Folder of episodes that are not yet in a shard; gone when the dataset is complete."""
ERRORS = "errors.jsonl"
"""One line for each failed attempt, with its traceback."""
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


@contextmanager
def sole_writer(out: Path) -> Iterator[None]:
    """Keeps other runs out of the folder; ends with the process, however that ends.

    Raises:
        OutputError: Another run writes there.
    """
    work = out / WORK
    work.mkdir(parents=True, exist_ok=True)
    with (work / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            msg = f"output folder '{out}' is being written by another run"
            raise OutputError(msg) from None
        try:
            yield
        finally:
            (work / "lock").unlink(missing_ok=True)
            with suppress(OSError):  # not empty, or gone
                work.rmdir()


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


def log_failures(out: Path, number: int, failures: tuple[Failure, ...], *, unit: str = "episode") -> None:
    """Adds the failed attempts at one unit of work to the error log, by its number."""
    if not failures:
        return
    lines = [
        json.dumps({unit: number, "kind": str(each.kind), "message": each.message, "traceback": each.traceback})
        for each in failures
    ]
    with (out / ERRORS).open("a", encoding="utf-8") as log:
        log.write("".join(f"{line}\n" for line in lines))
        log.flush()
        os.fsync(log.fileno())
