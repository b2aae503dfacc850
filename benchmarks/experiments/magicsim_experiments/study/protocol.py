"""What a study is: stages that leave files in a folder, and a result that is made of those files."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
import numpy.typing as npt
from pydantic import Field

from magicsim.config.models import Config
from magicsim.config.named_files import config_digest
from magicsim.folder.ledger import Ledger
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import Seed
from magicsim.workers.attempt import WorkerOptions
from magicsim.workers.run_folder import CONFIG, RunFolder, RunIndex

Cell = float | int | str | bool | None
Row = Mapping[str, Cell]


def column_of(rows: Sequence[Row], name: str) -> list[float]:
    """A column of numbers, NaN where a row has none."""
    return [float(each) if isinstance(each := row.get(name), int | float) else math.nan for row in rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column of a table."""

    name: str
    """Key of the rows; ends with its unit where it has one, such as `error_mm`."""
    title: str = ""
    """Head on the page; the name in words by default."""
    unit: str = ""
    digits: int = 3
    """Decimals on the page; files have all of them."""


UNITS = {"mm": "mm", "deg": "degrees", "n": "N", "nmm": "N mm", "mpa": "MPa", "px": "px"}
"""Ends of columns' names that are units, as files and pages write them."""


def columns_of(names: Iterable[str], titles: Mapping[str, str], *, digits: int = 3) -> tuple[Column, ...]:
    """Columns whose units are the ends of their names; titles by name, of those that have one."""
    return tuple(
        Column(name=name, title=titles.get(name, ""), unit=UNITS.get(name.rpartition("_")[2], ""), digits=digits)
        for name in names
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of the result: a Parquet file, a list in the JSON, a table on the page."""

    name: str
    """Name of the file, without its end."""
    title: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    note: str = ""
    """What a reader has to know to read it."""
    shown: int = 60
    """Rows on the page at most; files have all of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Matrix:
    """How often each true answer (rows) was given as which (columns)."""

    name: str
    title: str
    truths: tuple[str, ...]
    answers: tuple[str, ...]
    counts: npt.NDArray[np.int64]
    right: npt.NDArray[np.bool_]
    """Which of them count as right, of the same shape."""
    note: str = ""

    def as_table(self) -> Table:
        """The matrix as a table of files, a row a pair of truth and answer."""
        rows: tuple[Row, ...] = tuple(
            {"truth": truth, "answer": answer, "count": int(self.counts[place]), "right": bool(self.right[place])}
            for row, truth in enumerate(self.truths)
            for column, answer in enumerate(self.answers)
            for place in [(row, column)]
        )
        columns = tuple(Column(name=name) for name in ("truth", "answer", "count", "right"))
        return Table(name=self.name, title=self.title, columns=columns, rows=rows, note=self.note)


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A drawing of the page."""

    name: str
    title: str
    svg: str
    """An `svg` element, see `magicsim.report.drawing.to_svg`."""
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult:
    """All that a study found."""

    headline: Mapping[str, Cell]
    """Few numbers that sum it up, with units in their names."""
    tables: tuple[Table, ...]
    matrices: tuple[Matrix, ...] = ()
    figures: tuple[Figure, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
    """What it was made of, in words: frames, presses, units."""
    notes: tuple[str, ...] = ()
    """Sentences: what was left out against the protocol, what a number rests on."""


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
        return config_digest(self.model_dump(mode="json", exclude={"timeout_s"}))


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Workshop:
    """Where a stage works."""

    ledger: Ledger
    """Knows the study's files."""
    options: WorkerOptions
    """Where and how to compute; changes no result."""
    tell: Callable[[float, str], None]
    """Takes the share of the stage that is done, 0 to 1, and a note."""
    below: str = ""
    """Name of the folder below the study's in which the stage works, with a slash at its end; empty for the study's."""

    @property
    def folder(self) -> Path:
        """Folder in which the stage works."""
        return self.ledger.out / self.below

    def place(self, name: str, content: bytes) -> None:
        """Gives a file of that folder its content; the stage's own names begin with its name."""
        self.ledger.place(self.below + name, content)

    def remove(self, name: str) -> None:
        """Removes a file of that folder; one that is not there is no error."""
        self.ledger.remove(self.below + name)


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


class Study:
    """One kind of study, with its settings."""

    settings: ClassVar[type[StudyConfig]]
    """Model of its file."""
    packages: tuple[str, ...] = ()
    """Packages beyond those of the program whose versions its results depend on."""

    def __init__(self, config: StudyConfig) -> None:
        """Takes the settings, an instance of `settings`."""
        self.config = config

    def refuse(self) -> None:
        """Refuses what cannot be done, before any work.

        Raises:
            ConfigError: The design, or other settings, do not allow this study; one line says why.
        """

    def stages(self) -> Sequence[Stage]:
        """The work, in order."""
        raise NotImplementedError

    def conclude(self, folder: Path) -> StudyResult:
        """The result, from what the stages left in a folder; nothing is computed here that takes long."""
        raise NotImplementedError
