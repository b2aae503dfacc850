"""The folder that a dataset grows in: what it may hold before, and episodes that wait for their shard."""

from pathlib import Path

import pyarrow as pa

from magicsim.dataset.manifest import MANIFEST, Manifest, read_manifest, written_files
from magicsim.dataset.preview.preview_files import PREVIEW_FILES
from magicsim.dataset.shard import read_rows
from magicsim.errors import OutputError
from magicsim.folder.ledger import WORK, Ledger, is_begun
from magicsim.folder.result import names_in, output_errors, refuse_foreign, refuse_others
from magicsim.workers.log import ERRORS, changed_lines

STAGED = f"{WORK}/episode-*.parquet"
"""Finished episodes that wait for their shard, by number."""


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a dataset that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    with output_errors(out):
        names = set(names_in(out)) - PREVIEW_FILES
        manifest = begun_dataset(out)
    if not (out / MANIFEST).is_file() and not is_begun(out):
        refuse_others(out, names)
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
    if manifest is None or manifest.shards or manifest.failed or any(out.glob(STAGED)):
        return manifest
    return None


def open_ledger(out: Path) -> Ledger:
    """What earlier runs wrote into a dataset's folder, which may hold nothing else.

    Raises:
        OutputError: It does, and names it.
    """
    refuse_foreign(out, [ERRORS] if changed_lines(out) else [])
    ledger = Ledger(out, written_files(out))
    ledger.refuse_foreign(beside={ERRORS, *PREVIEW_FILES})
    return ledger


class Staging:
    """Finished episodes on disk, each whole or not there."""

    def __init__(self, ledger: Ledger) -> None:
        """Looks at what is there, and drops what is damaged."""
        self._ledger = ledger
        self._waiting: set[int] = set()
        for path in sorted(ledger.out.glob(STAGED)):
            episode = int(path.stem.partition("-")[2])
            if ledger.is_intact(_name(episode)):
                self._waiting.add(episode)
            else:
                ledger.remove(_name(episode))

    def episodes(self) -> set[int]:
        """Numbers of the episodes that wait."""
        return set(self._waiting)

    def put(self, episode: int, content: bytes) -> None:
        """Takes a finished episode."""
        self._ledger.place(_name(episode), content)
        self._waiting.add(episode)

    def table(self, episode: int) -> pa.Table:
        """Rows of an episode."""
        return read_rows(self._ledger.out / _name(episode))

    def drop(self, episodes: tuple[int, ...]) -> None:
        """Forgets episodes that are in a finished shard."""
        for episode in episodes:
            self._ledger.remove(_name(episode))
            self._waiting.discard(episode)


def _name(episode: int) -> str:
    return f"{WORK}/episode-{episode:08d}.parquet"
