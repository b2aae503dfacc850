"""The folder that a study grows in, and the index that says what it belongs to."""

from collections.abc import Callable
from pathlib import Path

import tomli_w
from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.errors import OutputError
from magicsim.folder.hashing import sha256_of
from magicsim.folder.ledger import Ledger, is_begun
from magicsim.folder.listing import Listed, files_below
from magicsim.folder.result import names_in, output_errors, refuse_foreign, refuse_others
from magicsim.folder.sealing import is_sealed, sealed
from magicsim.study.settings import StudyConfig
from magicsim.workers.log import ERRORS, changed_lines
from magicsim.workers.versions import changed_versions

INDEX, CONFIG, RESULTS, REPORT = "study.json", "config.toml", "results.json", "report.html"


class StudyIndex(Config):
    """What a folder's files belong to."""

    schema_version: int = 1
    kind: str
    config_hash: str
    """SHA-256 of what the result depends on (`StudyConfig.config_hash`)."""
    versions: dict[str, str]
    variant: str
    is_complete: bool = False
    files: dict[str, str] = Field(default_factory=dict)
    """SHA-256 of every other file of a finished study, those of datasets aside, which have a list of their own."""
    sha256: str = ""
    """Hash of this index itself, see `magicsim.folder.sealing`."""


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a study that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    with output_errors(out):
        names = set(names_in(out))
        index = read_index(out)
    if index is None and not is_begun(out):
        refuse_others(out, names)
    if index is not None and not resume:
        state = "a" if index.is_complete else "an unfinished"
        msg = f"output folder '{out}' holds {state} study already; --resume goes on with it"
        raise OutputError(msg)


def read_index(out: Path) -> StudyIndex | None:
    """The index of a folder, None where there is none.

    Raises:
        OutputError: It is not one that this version understands.
    """
    path = out / INDEX
    if not path.is_file():
        return None
    try:
        return validate(StudyIndex, read_json(path), source=INDEX)
    except (ValueError, OSError) as error:
        msg = f"'{path}' is not an index of a study: {error}"
        raise OutputError(msg) from None


def open_ledger(out: Path, *, owned: Callable[[str], bool]) -> Ledger:
    """What earlier runs wrote into a study's folder, which may hold nothing else.

    Args:
        out: The folder.
        owned: Whether another list answers for a file, by its name.

    Raises:
        OutputError: It holds something else, or something has changed since, and is named.
    """
    index = read_index(out)
    if index is not None and not is_sealed((out / INDEX).read_bytes()):
        refuse_foreign(out, [INDEX])
    known = {name: Listed(sha256=digest) for name, digest in (index.files if index is not None else {}).items()}
    if index is not None:
        known[INDEX] = Listed(sha256=sha256_of(out / INDEX))
    refuse_foreign(out, [ERRORS] if changed_lines(out) else [])
    ledger = Ledger(out, known)
    ledger.refuse_foreign(beside={ERRORS, *(name for name in files_below(out) if owned(name))})
    return ledger


def refuse_another(out: Path, earlier: StudyIndex, now: StudyIndex) -> None:
    """Refuses to go on with another study's files.

    Raises:
        OutputError: With what differs.
    """
    if (earlier.kind, earlier.config_hash) != (now.kind, now.config_hash):
        msg = f"'{out}' holds another study (see its {CONFIG}); name another folder"
        raise OutputError(msg)
    changed = changed_versions(earlier.versions | {"variant": earlier.variant}, now.versions | {"variant": now.variant})
    if changed:
        msg = f"'{out}' was begun with another version of {', '.join(changed)}: its results would differ"
        raise OutputError(msg)


def write_index(ledger: Ledger, index: StudyIndex) -> None:
    """Replaces the index at once."""
    ledger.place(INDEX, sealed(index.model_dump(mode="json")))


def write_config(ledger: Ledger, config: StudyConfig) -> None:
    """Writes the study with everything in place."""
    text = tomli_w.dumps(config.model_dump(mode="json", exclude_none=True))
    ledger.place(CONFIG, f"# A study of magicsim, everything in place: `magicsim study {CONFIG}`\n{text}".encode())
