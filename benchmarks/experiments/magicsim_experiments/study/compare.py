"""One study on several designs, or on one with single constants changed: their tables as one."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from magicsim.config.models import Config, in_place, validate
from magicsim.errors import ConfigError, MagicsimError
from magicsim.folder.ledger import WORK
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.workers.run_folder import CONFIG, ERRORS
from magicsim_experiments.study.learned.learned_study import LearnedStudy, pairs_figures, pairs_table
from magicsim_experiments.study.protocol import (
    DATA,
    INDEX,
    MODELS,
    PIECES,
    REPORT,
    RESULTS,
    TABLES,
    Cell,
    Column,
    Row,
    Stage,
    Study,
    StudyConfig,
    StudyResult,
    Table,
    Workshop,
)
from magicsim_experiments.study.study_file import merged, named_table, study_class, usual_rig, without_small_form


@dataclass(frozen=True, slots=True, kw_only=True)
class Within:
    """Runs a stage in a folder below the study's."""

    name: str
    folder: str
    stage: Stage

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
        """Does what is left, in the folder below."""
        below = replace(workshop, below=f"{self.folder}/")
        below.folder.mkdir(exist_ok=True)
        self.stage.run(below)
        with suppress(OSError):  # not there, or something is in it
            (below.folder / WORK).rmdir()


TAKEN = (CONFIG, DATA, ERRORS, INDEX, MODELS, PIECES, REPORT, RESULTS, TABLES)
"""Files and folders of every study; some disks do not tell `Data` from `data`."""
_FORM = re.compile(r"\w[\w .-]{0,59}")


def _checked(name: str) -> str:
    if not _FORM.fullmatch(name):
        raise ValueError(
            f"'{name}' is not allowed as a name: must be letters, digits, '_', '-', '.' and spaces, at most 60, and "
            "begin with one of the first three"
        )
    if name.casefold() in {each.casefold() for each in TAKEN}:
        raise ValueError(f"'{name}' is not allowed as a name: a study has a file or folder that is called so")
    return name


DesignName = Annotated[str, AfterValidator(_checked)]
ITSELF = "design"
"""What a design without a name is called."""
GIVEN = ("schema_version", "design", "rig", "seed", "quick")
"""Keys of the compared study that this one gives."""


class Compared(Config):
    """A further design."""

    name: DesignName
    """What it is called, and its folder."""
    design: ElastomerDesign
    rig: Rig


class CompareConfig(StudyConfig):
    """Settings of the study: its own design and rig are the first that is compared."""

    kind: Literal["compare"]
    name: DesignName = ITSELF
    """What the first design is called."""
    study: dict[str, Any]
    """The study that every design does, a table as in its own file; a file may give its name instead."""
    others: Annotated[tuple[Compared, ...], Field(min_length=1)]
    """Further designs; a file may give their names instead of tables, or `changes` of the first design and its rig, a
    list of `design.key=value` and `rig.key=value`."""

    @classmethod
    def of_another_design(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Content without the name of the design that stood in the file."""
        return {key: value for key, value in data.items() if key != "name"}

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The file's content with the compared study and all designs in place."""
        inner = without_small_form(named_table(data.get("study"), "study", folder), source="study", quick=quick)
        inner = merged(inner, _changes(data.pop("study_changes", {})))
        kind = str(inner.get("kind", ""))
        if kind == "compare":
            raise ConfigError("study = 'compare' is not allowed: a comparison compares another study")
        inner = study_class(kind).settings.completed(inner, folder=folder, quick=quick)
        first = {"design": data["design"], "rig": data["rig"]}
        others = data.get("others", [])
        if not isinstance(others, list):
            raise ConfigError(f"others = {others!r} is not allowed: must be a list of designs, names or tables")
        return {"name": _name_of(data["design"])} | data | {
            "study": {key: value for key, value in inner.items() if key not in GIVEN},
            "others": [_compared(each, first, folder) for each in others],
        }  # fmt: skip


class Compare(Study):
    """The study `compare`."""

    settings = CompareConfig
    config: CompareConfig

    def __init__(self, config: CompareConfig) -> None:
        """Takes the settings, and lays out the study of each design; one that cannot do it is left out, with why."""
        super().__init__(config)
        first = Compared(name=config.name, design=config.design, rig=config.rig)
        self._studies: dict[str, Study] = {}
        self._refused: dict[str, str] = {}
        for each in (first, *config.others):
            try:
                study = _study_of(config, each)
                study.refuse()
            except MagicsimError as error:
                self._refused[each.name] = str(error)
                continue
            self._studies[each.name] = study
        self.packages = next(iter(self._studies.values())).packages if self._studies else ()

    def refuse(self) -> None:
        """Refuses designs of one name, and a comparison of which nothing is left."""
        names = [self.config.name, *(each.name for each in self.config.others)]
        if len(set(names)) < len(names):
            raise ConfigError(f"others = {names[1:]} is not allowed beside '{names[0]}': must all differ")
        if self.config.name in self._refused or not self._studies:
            raise ConfigError(next(iter(self._refused.values())))

    def stages(self) -> Sequence[Stage]:
        """The stages of every design, in a folder of its own each."""
        return [
            Within(name=f"{name}/{stage.name}", folder=name, stage=stage)
            for name, study in self._studies.items()
            for stage in study.stages()
        ]

    def conclude(self, folder: Path) -> StudyResult:
        """The tables of all designs, one below the other."""
        found = {name: study.conclude(folder / name) for name, study in self._studies.items()}
        seen = {
            name: each.seen(folder / name) for name, each in self._studies.items() if isinstance(each, LearnedStudy)
        }
        pairs = [pairs_table(seen, seed=self.config.seed)] if len(seen) > 1 else []
        headline: dict[str, Cell] = {
            f"{name}.{key}": value for name, result in found.items() for key, value in result.headline.items()
        }
        first = next(iter(found.values()))
        return StudyResult(
            headline=headline,
            tables=(headline_table(found), *pairs, *(joined(found, table.name) for table in first.tables)),
            figures=tuple(figure for each in pairs for figure in pairs_figures(each)),
            matrices=tuple(
                replace(matrix, name=f"{matrix.name}-{name}", title=f"{name}: {matrix.title}")
                for name, result in found.items()
                for matrix in result.matrices
            ),
            facts={
                f"{name}: {key.lower()}": value
                for name, result in found.items()
                for key, value in result.facts.items()
            },
            notes=(
                *(f"{name} is left out: {why}." for name, why in self._refused.items()),
                *first.notes,
                *(f"{name}: {note}" for name, each in found.items() for note in each.notes if note not in first.notes),
            ),
        )  # fmt: skip


def headline_table(found: dict[str, StudyResult]) -> Table:
    """The numbers that sum each design's study up, a row each number and a column each design."""
    keys = dict.fromkeys(key for result in found.values() for key in result.headline)
    rows: list[Row] = [
        {"what": key, **{name: _as_number(result.headline.get(key)) for name, result in found.items()}} for key in keys
    ]
    columns = (Column(name="what"), *(Column(name=name) for name in found))
    return Table(name="compared", title="Designs compared", columns=columns, rows=tuple(rows))


def joined(found: dict[str, StudyResult], name: str) -> Table:
    """One table of all designs, a row says of which."""
    tables = {design: table for design, result in found.items() for table in result.tables if table.name == name}
    first = next(iter(tables.values()))
    rows = tuple({"design": design, **row} for design, table in tables.items() for row in table.rows)
    return replace(first, columns=(Column(name="design"), *first.columns), rows=rows, shown=len(tables) * first.shown)


def _compared(each: object, first: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A further design from its name or its table; the first one with its changes where it names none."""
    if not isinstance(each, str | dict):
        raise ConfigError(f"others holds {each!r}, which is not allowed: must be a name or a table")
    table: dict[str, Any] = {"design": each} if isinstance(each, str) else dict(each)
    if "design" not in table:
        table = first | table
    named = table.get("design")
    table.setdefault("name", _name_of(named))
    table.setdefault("rig", usual_rig(named))
    changes = table.pop("changes", [])
    if not isinstance(changes, list) or not all(isinstance(one, str) for one in changes):
        msg = f"changes = {changes!r} is not allowed; must be a list of settings such as 'design.skin_mm=1'"
        raise ConfigError(msg)
    return in_place(table, folder, changes)


def _name_of(design: object) -> str:
    """What a design is called that has no name of its own: as its file, where it is one."""
    return Path(design).stem if isinstance(design, str) else ITSELF


def _changes(found: object) -> dict[str, Any]:
    """The changes of the compared study, refused where they are no table, or change what the comparison gives."""
    if not isinstance(found, dict):
        msg = f"study_changes = {found!r} is not allowed: must be a table of settings of the compared study"
        raise ConfigError(msg)
    for key in GIVEN:
        if key in found:
            msg = f"study_changes.{key} = {found[key]!r} is not allowed: must be a setting of the compared study alone"
            raise ConfigError(msg)
    return found


def _study_of(config: CompareConfig, each: Compared) -> Study:
    found = study_class(str(config.study.get("kind", "")))
    data = {
        **config.study, "schema_version": 1, "seed": config.seed, "design": each.design.model_dump(),
        "rig": each.rig.model_dump(), "timeout_s": config.timeout_s,
    }  # fmt: skip
    return found(validate(found.settings, data, source=f"study of {each.name}"))


def _as_number(value: Cell) -> Cell:
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value
