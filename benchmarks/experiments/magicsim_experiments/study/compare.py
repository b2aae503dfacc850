"""One study on several designs, or on one with single constants changed: their tables as one."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from magicsim.config.models import Config, in_place, validate
from magicsim.errors import ConfigError, MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim_experiments.study.design_name import DesignName
from magicsim_experiments.study.kinds import study_class
from magicsim_experiments.study.protocol import Stage, Study
from magicsim_experiments.study.result import Cell, Column, Matrix, Row, StudyResult, Table
from magicsim_experiments.study.settings import StudyConfig
from magicsim_experiments.study.stages.within import Within
from magicsim_experiments.study.study_file import merged, named_table, usual_rig, without_small_form

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
            msg = "study = 'compare' is not allowed: a comparison compares another study"
            raise ConfigError(msg)
        inner = study_class(kind).settings.completed(inner, folder=folder, quick=quick)
        first = {"design": data["design"], "rig": data["rig"]}
        others = data.get("others", [])
        if not isinstance(others, list):
            msg = f"others = {others!r} is not allowed: must be a list of designs, names or tables"
            raise ConfigError(msg)
        return {"name": _name_of(data["design"])} | data | {
            "study": {key: value for key, value in inner.items() if key not in GIVEN},
            "others": [_compared(each, first, folder) for each in others],
        }  # fmt: skip


class Compare:
    """The study `compare`."""

    settings: ClassVar[type[StudyConfig]] = CompareConfig
    packages: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: CompareConfig) -> None:
        """Takes the settings, and lays out the study of each design; one that cannot do it is left out, with why."""
        self.config = config
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
        self.packages = next(iter(self._studies.values())).packages if self._studies else ()  # type: ignore[misc]

    def refuse(self) -> None:
        """Refuses designs of one name, and a comparison of which nothing is left.

        Raises:
            ConfigError: With what is wrong.
        """
        names = [self.config.name, *(each.name for each in self.config.others)]
        if len(set(names)) < len(names):
            msg = f"others = {names[1:]} is not allowed beside '{names[0]}': must all differ"
            raise ConfigError(msg)
        if self.config.name in self._refused or not self._studies:
            raise ConfigError(next(iter(self._refused.values())))

    def stages(self) -> Sequence[Stage]:
        """The stages of every design, in a folder of its own each."""
        return [Within(folder=name, stage=stage) for name, study in self._studies.items() for stage in study.stages()]

    def conclude(self, folder: Path) -> StudyResult:
        """The tables of all designs, one below the other."""
        found = {name: study.conclude(folder / name) for name, study in self._studies.items()}
        headline: dict[str, Cell] = {
            f"{name}.{key}": value for name, result in found.items() for key, value in result.headline.items()
        }
        first = next(iter(found.values()))
        return StudyResult(
            headline=headline,
            tables=(headline_table(found), *(joined(found, table.name) for table in first.tables)),
            matrices=tuple(
                renamed(matrix, name) for name, result in found.items() for matrix in result.matrices
            ),
            facts={
                f"{name}: {key.lower()}": value
                for name, result in found.items()
                for key, value in result.facts.items()
            },
            notes=(*(f"{name} is left out: {why}." for name, why in self._refused.items()), *first.notes),
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


def renamed(matrix: Matrix, design: str) -> Matrix:
    """A matrix that says of which design it is."""
    return replace(matrix, name=f"{matrix.name}-{design}", title=f"{design}: {matrix.title}")


def _compared(each: object, first: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A further design from its name or its table; the first one with its changes where it names none."""
    if not isinstance(each, str | dict):
        msg = f"others holds {each!r}, which is not allowed: must be a name or a table"
        raise ConfigError(msg)
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
    """The changes of the compared study.

    Raises:
        ConfigError: They are no table, or change what the comparison gives.
    """
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
