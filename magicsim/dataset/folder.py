"""The folder that a dataset grows in: what it may hold before, episodes that wait for their shard, and a preview."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa

from magicsim.dataset.manifest import MANIFEST, Manifest, read_manifest, written_files
from magicsim.dataset.shard import read_rows
from magicsim.errors import OutputError
from magicsim.folder.ledger import WORK, Ledger, is_begun
from magicsim.folder.listing import is_sealed, sealed, sha256_of
from magicsim.folder.result import names_in, output_errors, refuse_foreign, refuse_others
from magicsim.folder.result_file import result_file
from magicsim.workers.run_folder import ERRORS, changed_lines

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


SHEET, STATISTICS = "preview.png", "preview.json"
PREVIEW_FILES = frozenset({SHEET, STATISTICS})
SHEETS = "sheet_sha256"
"""Key of the statistics: hashes of the sheet and, in case a run is killed between both files, of the one before."""


def check_preview(out: Path) -> None:
    """Refuses to replace a picture or a file of that name that magicsim did not write.

    Raises:
        OutputError: It names them, or the folder cannot be read.
    """
    with output_errors(out):
        refuse_foreign(out, changed_preview(out))


def changed_preview(out: Path) -> list[str]:
    """Names of a folder's preview files that are not as they were written."""
    sheet, statistics = out / SHEET, out / STATISTICS
    if not statistics.exists():
        return [SHEET] if sheet.exists() else []
    if not is_sealed(statistics.read_bytes()):
        return [name for name in sorted(PREVIEW_FILES) if (out / name).exists()]
    known = json.loads(statistics.read_bytes()).get(SHEETS, [])
    return [SHEET] if sheet.exists() and sha256_of(sheet) not in known else []


def write_preview(out: Path, sheet: bytes, statistics: Mapping[str, Any]) -> None:
    """Writes both files, each whole or not at all.

    Args:
        out: Their folder.
        sheet: PNG file.
        statistics: Values for JSON.

    Raises:
        OutputError: They cannot be written, or would replace something that magicsim did not write.
    """
    check_preview(out)
    hashes = [hashlib.sha256(sheet).hexdigest()]
    if (out / SHEET).exists():
        hashes.append(sha256_of(out / SHEET))
    with result_file(out / STATISTICS) as partial:
        partial.write_bytes(sealed({**statistics, SHEETS: hashes}))
    with result_file(out / SHEET) as partial:
        partial.write_bytes(sheet)
