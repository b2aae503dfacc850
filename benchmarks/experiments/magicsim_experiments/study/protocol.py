"""What a study is: stages that leave files in a folder, and a result that is made of those files."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol

from pydantic import Field

from magicsim.config.models import Config
from magicsim.config.named_files import config_digest
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import Seed
from magicsim.workers.options import WorkerOptions
from magicsim.workers.run_folder import CONFIG, RunFolder, RunIndex
from magicsim_experiments.study.result import StudyResult


class StudyConfig(Config):
    """Settings of a study."""

    schema_version: Literal[1]
    kind: str
    """What is studied, a key of `magicsim_experiments.study.study_file.KINDS`."""
    design: ElastomerDesign
    """The block; a file or `--design` may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead. Left out, it is the rig of the scene that
    has the design's name, or `digit-office`."""
    seed: Seed = 0
    """Seed of everything random."""
    timeout_s: Annotated[float, Field(ge=0.001, le=1e6)] = 1800.0
    """Longest time for one attempt at a part of the work [s]."""

    @classmethod
    def of_another_design(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Content of a file whose own design, a table, has been replaced by one that was named."""
        return data

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The file's content with what this kind of study names, such as a recipe, put in place.

        Args:
            data: Content; design and rig may still be names.
            folder: Where the file stands.
            quick: Whether the small form was asked for.
        """
        return data

    def config_hash(self) -> str:
        """SHA-256 of everything that the result depends on, the content of files that are named included."""
        data = self.model_dump(mode="json", exclude={"timeout_s"})
        return config_digest(data)


INDEX, RESULTS, REPORT = "study.json", "results.json", "report.html"
DATA, MODELS, PIECES, TABLES = "data", "models", "pieces", "tables"
"""Folders below it: datasets, what is learned, pieces of other stages, and the result as Parquet."""


class StudyIndex(RunIndex):
    """What a folder's files belong to; those of datasets have a list of their own."""

    kind: str


FOLDER = RunFolder(
    index=INDEX, model=StudyIndex, noun="study", content="study",
    title=f"A study of magicsim, everything in place: `magicsim study {CONFIG}`",
)  # fmt: skip


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
        """Does what is left."""


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
