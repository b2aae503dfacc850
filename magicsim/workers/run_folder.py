"""What stands in a folder that a run grows in over several calls: index, settings, versions, and a log of failures."""

import errno
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

import tomli_w
from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.config.program import other_code
from magicsim.errors import OutputError
from magicsim.folder.ledger import Ledger, is_begun
from magicsim.folder.listing import Listed, files_below, is_sealed, sealed, sha256_of
from magicsim.folder.target import check_place, names_in, output_errors, refuse_foreign, refuse_others
from magicsim.workers.attempt import Failure

CONFIG = "config.toml"
"""Settings of a run with everything in place."""
ERRORS = "errors.jsonl"
"""One line for each failed attempt, with its traceback."""


def log_failures(out: Path, unit: str, number: int, failures: tuple[Failure, ...]) -> None:
    """Adds the failed attempts at one unit of work, such as an episode, to the error log, by its number."""
    if not failures:
        return
    entries = [{"kind": str(each.kind), "message": each.message, "traceback": each.traceback} for each in failures]
    lines = b"".join(sealed({unit: number, **each}, indent=None) for each in entries)
    with (out / ERRORS).open("ab", buffering=0) as log:
        end = log.tell()
        try:
            if log.write(lines) < len(lines):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(log.fileno())
        except OSError:  # a line that is cut off would count as changed
            log.truncate(end)
            raise


def changed_lines(out: Path) -> list[int]:
    """Numbers, from 1, of the lines of a folder's error log that are not as they were written; none without a log."""
    path = out / ERRORS
    lines = path.read_bytes().splitlines(keepends=True) if path.is_file() else []
    return [number for number, line in enumerate(lines, 1) if not is_sealed(line, indent=None)]


class RunIndex(Config):
    """Index of a folder: what its files belong to, and one list of them."""

    schema_version: Literal[1] = 1
    config_hash: str
    """SHA-256 of what results depend on."""
    versions: dict[str, str]
    """See `magicsim.config.program.versions`."""
    variant: str
    is_complete: bool = False
    files: dict[str, str] = Field(default_factory=dict)
    """SHA-256 of every other file of a finished run, those aside that another list answers for."""
    sha256: str = ""
    """Hash of this index itself, see `magicsim.folder.listing.sealed`."""

    def listed(self) -> dict[str, Listed]:
        """What every other file was when it was written, by name."""
        return {name: Listed(sha256=digest) for name, digest in self.files.items()}


Index = TypeVar("Index", bound=RunIndex)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFolder(Generic[Index]):
    """How one kind of run keeps its folder."""

    index: str
    """Name of the index's file."""
    model: type[Index]
    noun: str
    """What is run, as it is called in messages, after *a*."""
    content: str
    """What of it the folder holds, likewise."""
    title: str = ""
    """First line of the settings' file."""
    other: str = ""
    """What a folder holds whose index has another hash; another *noun* by default."""
    beside: frozenset[str] = frozenset()
    """Names of files that another list answers for."""
    is_worth_keeping: Callable[[Path, Index], bool] = lambda _out, _index: True
    """Whether a folder with an index holds what only `--resume` may go on with."""

    def check(self, out: Path, *, resume: bool) -> None:
        """Refuses (`OutputError`) a folder that is not ours, cannot be written, or holds a run without `resume`."""
        with output_errors(out):
            names = set(names_in(out)) - self.beside
            index = self.begun(out)
        if not (out / self.index).is_file() and not is_begun(out):
            refuse_others(out, names)
        if index is not None and not resume:
            state = "an unfinished" if is_begun(out) else "a"
            raise OutputError(f"output folder '{out}' holds {state} {self.content} already; --resume goes on with it")
        check_place(out)

    def begun(self, out: Path) -> Index | None:
        """The index of a folder; None also where nothing was ever finished, so that nothing is lost."""
        index = self.read_index(out)
        return index if index is not None and self.is_worth_keeping(out, index) else None

    def read_index(self, out: Path) -> Index | None:
        """The index of a folder, None without one; `OutputError` where this version does not understand it."""
        path = out / self.index
        if not path.is_file():
            return None
        try:
            return validate(self.model, read_json(path), source=self.index)
        except (ValueError, OSError) as error:
            raise OutputError(f"'{path}' is not an index of a {self.noun}: {error}") from None

    def is_unchanged(self, out: Path) -> bool:
        """Whether a folder's index is byte for byte as it was written."""
        return is_sealed((out / self.index).read_bytes())

    def open_ledger(self, out: Path, *, owned: Callable[[str], bool] = lambda _: False) -> Ledger:
        """What earlier runs wrote into a folder; `OutputError` where that has changed, or it holds anything else."""
        index, known = self.read_index(out), {}
        if index is not None:
            if not self.is_unchanged(out):
                msg = f"'{out / self.index}' has changed since it was written; put it back, or name another folder"
                raise OutputError(msg)
            known = index.listed() | {self.index: Listed(sha256=sha256_of(out / self.index))}
        refuse_foreign(out, [ERRORS] if changed_lines(out) else [])
        ledger = Ledger(out, known)
        ledger.refuse_foreign(beside={ERRORS, *self.beside, *filter(owned, files_below(out))})
        return ledger

    def refuse_another(self, out: Path, earlier: Index, now: Index, *, other: str = "") -> None:
        """Refuses (`OutputError`) to go on with the files of another run (`other` in its words), or of other code."""
        if earlier.config_hash != now.config_hash:
            another = other or self.other or f"another {self.noun} (see its {CONFIG})"
            raise OutputError(f"'{out}' holds {another}; name another folder")
        before, present = (each.versions | {"variant": each.variant} for each in (earlier, now))
        if code := other_code(before, present):
            raise OutputError(f"'{out}' was begun with {code}: its results would differ; begin anew in another folder")

    def write_index(self, ledger: Ledger, index: Index) -> None:
        """Replaces the index at once."""
        ledger.place(self.index, sealed(index.model_dump(mode="json")))

    def write_config(self, ledger: Ledger, settings: Config | Mapping[str, Any]) -> None:
        """Writes the settings with everything in place: a model, or plain values as TOML takes them."""
        plain = settings.model_dump(mode="json", exclude_none=True) if isinstance(settings, Config) else settings
        text = tomli_w.dumps(plain)
        ledger.place(CONFIG, f"# {self.title}\n{text}".encode())
