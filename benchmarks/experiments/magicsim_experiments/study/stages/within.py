"""A stage of one study as a part of another: what it leaves is in a folder of its own."""

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from magicsim.folder.ledger import WORK
from magicsim.workers.run_folder import ERRORS
from magicsim_experiments.study.protocol import Files, Stage, Workshop


@dataclass(frozen=True, slots=True, kw_only=True)
class Within:
    """Runs a stage in a folder below the study's."""

    folder: str
    """Name of that folder."""
    stage: Stage

    @property
    def name(self) -> str:
        """Folder and name of the stage."""
        return f"{self.folder}/{self.stage.name}"

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s]."""
        return self.stage.core_seconds(processes)

    def is_done(self, folder: Path) -> bool:
        """Whether the folder below has all of it."""
        return self.stage.is_done(folder / self.folder)

    def owns(self, name: str) -> bool:
        """Whether the stage, or the log of its errors, answers for a file."""
        first, _, rest = name.partition("/")
        return first == self.folder and (rest == ERRORS or self.stage.owns(rest))

    def run(self, workshop: Workshop) -> None:
        """Does what is left, in the folder below.

        Raises:
            MagicsimError: It cannot be done, in one line.
        """
        (workshop.folder / self.folder).mkdir(exist_ok=True)
        self.stage.run(replace(workshop, ledger=_Below(files=workshop.ledger, folder=self.folder)))
        with suppress(OSError):  # not there, or something is in it
            (workshop.folder / self.folder / WORK).rmdir()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Below:
    """The files of a folder below another."""

    files: Files
    folder: str

    @property
    def out(self) -> Path:
        """The folder below."""
        return self.files.out / self.folder

    def place(self, name: str, content: bytes) -> None:
        """Gives a file its content."""
        self.files.place(f"{self.folder}/{name}", content)

    def remove(self, name: str) -> None:
        """Removes a file."""
        self.files.remove(f"{self.folder}/{name}")
