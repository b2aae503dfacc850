"""The two files of a preview, which may stand in a dataset's folder: what shows that they are magicsim's."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from magicsim.folder.hashing import sha256_of
from magicsim.folder.result import output_errors, refuse_foreign
from magicsim.folder.result_file import result_file
from magicsim.folder.sealing import is_sealed, sealed

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
