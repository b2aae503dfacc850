"""The files of a folder that grows over several runs, so that magicsim replaces and removes nothing else there.

While the folder grows, a journal in it names every file, with its size and hash, before it gets its name. What stands
when the folder is whole is in an index of the folder's own, such as a dataset's manifest, and the journal goes.
"""

import json
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path

from magicsim.folder.listing import Listed, files_below, is_sealed, sealed, sha256_of
from magicsim.folder.target import is_lock, new_token, refuse_foreign

WORK = ".work"
"""Folder of what is not yet in its final place; gone when the run is complete."""
JOURNAL = "written.jsonl"
"""One line for each file, in that folder."""
PARTIAL = re.compile(r"[0-9a-f]{16}\.partial")
"""Names in that folder of files that are being written."""
UNEDITED = frozenset({".parquet", ".webp"})
"""Endings of files that nobody changes by hand."""
RESUMABLE = "; what is finished is kept, and --resume goes on from there"
"""What an error says of a folder that grows."""


def is_begun(out: Path) -> bool:
    """Whether a run has begun to write a folder and has not ended."""
    return (out / WORK / JOURNAL).is_file()


class Ledger:
    """The files of one growing folder; its writer has the folder's lock."""

    def __init__(self, out: Path, known: Mapping[str, Listed]) -> None:
        """Takes up what an earlier run has written, and removes what it had not finished."""
        self.out = out
        self._journal = out / WORK / JOURNAL
        self._written: dict[str, list[Listed]] = {name: [each] for name, each in known.items()}
        self._is_open = False
        for line in self._journal.read_bytes().splitlines(keepends=True) if self._journal.is_file() else ():
            if is_sealed(line, indent=None):  # one that is damaged, or was cut off, says nothing
                entry = json.loads(line)
                self._written.setdefault(entry["file"], []).append(Listed(**entry["facts"]))
        for path in self._journal.parent.glob("*.partial"):
            if PARTIAL.fullmatch(path.name):
                path.unlink()

    def names(self) -> list[str]:
        """Names below the folder of every written file that is there, in order."""
        return sorted(name for name in self._written if (self.out / name).is_file())

    def is_intact(self, name: str) -> bool:
        """Whether a file is there, as it was written."""
        return any(each.is_unchanged(self.out / name) for each in self._written.get(name, ()))

    def is_own(self, name: str) -> bool:
        """Whether a name is free, or its file may be replaced.

        A file of numbers or pixels that has the size it was written with is magicsim's, perhaps damaged: nobody edits
        such a file. Any other has to be intact.
        """
        path = self.out / name
        if not os.path.lexists(path):
            return True
        if path.suffix in UNEDITED and path.is_file() and not path.is_symlink():
            size = path.stat().st_size
            if any(each.size == size for each in self._written.get(name, ())):
                return True
        return self.is_intact(name)

    def refuse_foreign(self, *, beside: Collection[str] = ()) -> None:
        """Refuses (`OutputError`) what magicsim did not write or has changed; another list answers for `beside`."""
        others = {f"{WORK}/{JOURNAL}", *beside}
        names = [name for name in files_below(self.out) if name not in others and not is_lock(name)]
        refuse_foreign(self.out, [name for name in names if not self.is_own(name)])

    def place(self, name: str, content: bytes) -> None:
        """Gives a file its content under its final name, whole or not at all; refuses to replace somebody else's."""
        with self.writing(name) as partial:
            partial.write_bytes(content)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """A path to write a file at, which gets its name when the block ends without an error; see `place`."""
        if not self.is_own(name):
            refuse_foreign(self.out, [name])
        self._begin()
        path, partial = self.out / name, self._journal.with_name(f"{new_token()}.partial")
        try:
            yield partial
            with partial.open("rb+") as file:
                os.fsync(file.fileno())
            facts = Listed(size=partial.stat().st_size, sha256=sha256_of(partial))
            self._log([(name, facts)])
            self._written.setdefault(name, []).append(facts)
            path.parent.mkdir(parents=True, exist_ok=True)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
        _sync(path.parent)

    def remove(self, name: str) -> None:
        """Removes a file that magicsim wrote and that has not changed; one that is not there is no error."""
        if not self.is_own(name):
            refuse_foreign(self.out, [name])
        (self.out / name).unlink(missing_ok=True)

    def close(self) -> None:
        """Ends the journal, once an index of the folder lists what stands there."""
        self._journal.unlink(missing_ok=True)
        with suppress(OSError):  # somebody else's file is in it
            self._journal.parent.rmdir()

    def listed(self, name: str) -> Listed:
        """The file that was written last under a name."""
        return self._written[name][-1]

    def _begin(self) -> None:
        """Opens the journal with what is known: an index that lists some of it may be replaced from now on."""
        if not self._is_open:
            self._journal.parent.mkdir(parents=True, exist_ok=True)
            known = [(name, facts) for name, listed in self._written.items() for facts in listed]
            self._log(known, start=b"\n")  # the last line may have been cut off
            self._is_open = True

    def _log(self, entries: Iterable[tuple[str, Listed]], *, start: bytes = b"") -> None:
        lines = [sealed({"file": name, "facts": asdict(facts)}, indent=None) for name, facts in entries]
        with self._journal.open("ab") as journal:
            journal.write(start + b"".join(lines))
            journal.flush()
            os.fsync(journal.fileno())


def _sync(folder: Path) -> None:
    """Makes the names in a folder last."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
