"""The folder that a sweep grows in: one file a design, whole or not there, and what they belong to."""

from pathlib import Path

import tomli_w
from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.errors import OutputError
from magicsim.folder.hashing import sha256_of
from magicsim.folder.ledger import Ledger, is_begun
from magicsim.folder.listing import Listed
from magicsim.folder.result import names_in, output_errors, refuse_foreign, refuse_others
from magicsim.folder.sealing import is_sealed, sealed
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.workers.log import ERRORS, changed_lines
from magicsim.workers.versions import changed_versions

INDEX, CONFIG, DESIGNS, REPORT = "sweep.json", "config.toml", "designs", "report.html"
CSV, PARQUET, FRAMES = "sweep.csv", "sweep.parquet", "frames"


class SweepIndex(Config):
    """What a folder's results belong to."""

    schema_version: int = 1
    config_hash: str
    """SHA-256 of what results depend on (`SweepConfig.config_hash`)."""
    versions: dict[str, str]
    variant: str
    designs: int
    is_complete: bool = False
    failed: dict[str, str] = Field(default_factory=dict)
    """Why there is no result, by number of the design."""
    files: dict[str, str] = Field(default_factory=dict)
    """SHA-256 of every other file of a finished sweep."""
    sha256: str = ""
    """Hash of this index itself, see `magicsim.folder.sealing`."""


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a sweep that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    with output_errors(out):
        names = set(names_in(out))
        index = read_index(out)
    if index is None and not is_begun(out):
        refuse_others(out, names)
    if index is not None and not resume and any((out / DESIGNS).glob("*.json")):
        state = "a" if index.is_complete else "an unfinished"
        msg = f"output folder '{out}' holds {state} sweep already; --resume goes on with it"
        raise OutputError(msg)


def read_index(out: Path) -> SweepIndex | None:
    """The index of a folder, None where there is none.

    Raises:
        OutputError: It is not one that this version understands.
    """
    path = out / INDEX
    if not path.is_file():
        return None
    try:
        return validate(SweepIndex, read_json(path), source=INDEX)
    except (ValueError, OSError) as error:
        msg = f"'{path}' is not an index of a sweep: {error}"
        raise OutputError(msg) from None


def open_ledger(out: Path) -> Ledger:
    """What earlier runs wrote into a sweep's folder, which may hold nothing else.

    Raises:
        OutputError: It does, or something has changed since, and is named.
    """
    index = read_index(out)
    if index is not None and not is_sealed((out / INDEX).read_bytes()):
        refuse_foreign(out, [INDEX])
    known = {name: Listed(sha256=digest) for name, digest in (index.files if index is not None else {}).items()}
    if index is not None:
        known[INDEX] = Listed(sha256=sha256_of(out / INDEX))
    refuse_foreign(out, [ERRORS] if changed_lines(out) else [])
    ledger = Ledger(out, known)
    ledger.refuse_foreign(beside={ERRORS})
    return ledger


def write_index(ledger: Ledger, index: SweepIndex) -> None:
    """Replaces the index at once."""
    ledger.place(INDEX, sealed(index.model_dump(mode="json")))


def write_config(ledger: Ledger, sweep: SweepConfig) -> None:
    """Writes the sweep with everything in place."""
    config = tomli_w.dumps(sweep.model_dump(mode="json", exclude_none=True))
    ledger.place(CONFIG, f"# A sweep of magicsim, everything in place: `magicsim sweep {CONFIG}`\n{config}".encode())


def result_name(index: int) -> str:
    """Name of a design's result below the folder."""
    return f"{DESIGNS}/{index:05d}.json"


def read_results(out: Path, count: int) -> list[DesignResult]:
    """All results of a sweep's designs, in order; a design without one is left out."""
    return [result for index in range(count) if (result := read_result(out, index)) is not None]


def read_result(out: Path, index: int) -> DesignResult | None:
    """A design's result, None without one.

    Raises:
        OutputError: It cannot be read.
    """
    path = out / result_name(index)
    try:
        return DesignResult.from_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError) as error:
        msg = f"'{path}' is not a result of a sweep: {error}; without it, --resume judges the design again"
        raise OutputError(msg) from None


def refuse_another(out: Path, earlier: SweepIndex, now: SweepIndex) -> None:
    """Refuses to go on with another sweep's results.

    Raises:
        OutputError: With what differs.
    """
    if earlier.config_hash != now.config_hash:
        msg = f"'{out}' holds another sweep (see its {CONFIG}); name another folder"
        raise OutputError(msg)
    changed = changed_versions(earlier.versions | {"variant": earlier.variant}, now.versions | {"variant": now.variant})
    if changed:
        msg = f"'{out}' was begun with another version of {', '.join(changed)}: its results would differ"
        raise OutputError(msg)
