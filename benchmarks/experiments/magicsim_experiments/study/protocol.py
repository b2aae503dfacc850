"""What a study is: stages that leave files in a folder, and a result that is made of those files."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

from magicsim.workers.options import WorkerOptions
from magicsim_experiments.study.result import StudyResult
from magicsim_experiments.study.settings import StudyConfig


class Files(Protocol):
    """Writes files of a folder, each whole or not there; `magicsim.folder.ledger.Ledger` is one."""

    @property
    def out(self) -> Path:
        """The folder."""

    def place(self, name: str, content: bytes) -> None:
        """Gives a file its content under its name below the folder."""

    def remove(self, name: str) -> None:
        """Removes a file; one that is not there is no error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Workshop:
    """Where a stage works."""

    ledger: Files
    """Writes the folder's files; the stage's own names begin with its name."""
    options: WorkerOptions
    """Where and how to compute; changes no result."""
    tell: Callable[[float, str], None]
    """Takes the share of the stage that is done, 0 to 1, and a note."""

    @property
    def folder(self) -> Path:
        """Folder of the study."""
        return self.ledger.out


class Stage(Protocol):
    """One part of the work of a study. Whatever it leaves is the same however often it was killed meanwhile."""

    @property
    def name(self) -> str:
        """Unique in the study; a part of names of files."""

    def core_seconds(self, processes: int) -> float:
        """Rough time of the whole stage on one core [s], where so many processes share it."""

    def is_done(self, folder: Path) -> bool:
        """Whether the folder holds all that the stage leaves."""

    def owns(self, name: str) -> bool:
        """Whether another list than the study's answers for a file, by its name below the folder."""

    def run(self, workshop: Workshop) -> None:
        """Does what is left.

        Raises:
            MagicsimError: It cannot be done, in one line.
        """


class Study(Protocol):
    """One kind of study, with its settings."""

    settings: ClassVar[type[StudyConfig]]
    """Model of its file."""
    packages: ClassVar[tuple[str, ...]]
    """Packages beyond those of the program whose versions its results depend on."""

    def __init__(self, config: StudyConfig) -> None:
        """Takes the settings, an instance of `settings`."""

    @property
    def config(self) -> StudyConfig:
        """The settings."""

    def refuse(self) -> None:
        """Refuses what cannot be done, before any work.

        Raises:
            ConfigError: The design, or other settings, do not allow this study; one line says why.
        """

    def stages(self) -> Sequence[Stage]:
        """The work, in order."""

    def conclude(self, folder: Path) -> StudyResult:
        """The result, from what the stages left in a folder; nothing is computed here that takes long."""
