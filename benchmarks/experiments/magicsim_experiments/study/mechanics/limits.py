"""How hard skin and infill are used by domed indenters, by the thickness of the skin: forces, stretch, stress, flow."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim_experiments.study.mechanics.limit_press import (
    Beside,
    CellPress,
    Cells,
    LimitPress,
    LimitsConfig,
    LimitShear,
    case_of,
    cell_press,
    limit_press,
    limit_shear,
)
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Cell, Figure, Row, Study, StudyResult, Table, columns_of
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals

HEADS = {
    "fx_n": "Fx", "fy_n": "Fy", "fz_n": "Fz", "skin_von_mises_mpa": "von Mises stress of the skin",
    "yield_mpa": "assumed yield stress", "deepest_mm": "deepest computed",
}  # fmt: skip
FORCES, SKIN = ("fx_n", "fy_n", "fz_n"), ("skin_stretch", "skin_von_mises_mpa")
INFILL = ("least_infill_shear", "most_infill_shear")
TITLES = {
    "fz_n": "normal force [N]",
    "skin_stretch": "largest stretch of the skin",
    "skin_von_mises_mpa": "largest von Mises stress of the skin [MPa]",
}
NOTES = (
    "Stretch and stress are the largest at the Gauss points of the skin, of presses on the block with its effective "
    "core and two or more layers of cells across the skin; sheared presses have one layer, which tells less.",
    "Cells: walls are resolved below the indenter. Shear of the infill is the mean over a layer of the uppermost cube "
    "below the indenter, of its least and its most sheared layer.",
    "Nothing yields, flows or tears here: the elastic answer says where it would begin. The infill flows over a cell's "
    "height where the least sheared layer of that cube reaches the yield stress over its shear modulus.",
    "The yield stress of the infill is assumed: nobody has published one.",
    "A depth that does not converge has no numbers, and its row says why; deeper ones are not tried.",
)


class Limits(Study):
    """The study `limits`."""

    settings = LimitsConfig
    config: LimitsConfig

    def __init__(self, config: LimitsConfig) -> None:
        super().__init__(config)
        cases = [(config.with_skin(skin), diameter) for diameter in config.diameters_mm for skin in config.skins_mm]
        presses = [
            LimitPress(design=design, diameter_mm=diameter, depths_mm=config.depths_mm, friction=config.friction)
            for design, diameter in cases
        ]
        self.presses = PiecesStage(name="presses", function=limit_press, tasks=presses, seconds=60.0)
        beside = config.beside
        aside = [(config.with_skin(s), d) for d in beside.diameters_mm for s in beside.skins_mm] if beside else []
        above = _resolved(config, cases, config.cells, None)
        off = _resolved(config, aside, beside, (beside.x_mm, beside.y_mm) if beside else None)
        self.cells = PiecesStage(name="cells", function=cell_press, tasks=above, seconds=90.0)
        self.beside = PiecesStage(name="beside", function=cell_press, tasks=off, seconds=250.0)
        self.sheared = PiecesStage(name="sheared", function=limit_shear, tasks=_sheared(config), seconds=60.0)

    def refuse(self) -> None:
        """Refuses curved faces and presses through the block."""
        if self.config.design.face is not None:
            raise ConfigError("study 'limits' needs a flat face: design.face is set")
        config, sheared, beside = self.config, self.config.sheared, self.config.beside
        skins = {"beside.depths_mm": beside.skins_mm} if beside else {}
        cases = [(max(depths), skins.get(name, config.skins_mm)) for name, depths in config.paths_mm.items()]
        cases += [(max(depth for depth, _ in sheared.paths_mm), (sheared.skin_mm,))] if sheared else []
        for deepest, those in cases:
            most = MAX_DEPTH_SHARE * min((config.with_skin(skin).height_mm for skin in those), default=np.inf)
            if deepest > most:
                raise ConfigError(f"depths_mm = {deepest:g} is not allowed: at most {most:g}, 90 % of the height")

    def stages(self) -> Sequence[PiecesStage]:
        """Presses, those with resolved walls above and beside the middle of a cell, and sheared ones."""
        return self.presses, self.cells, self.beside, self.sheared

    def conclude(self, folder: Path) -> StudyResult:
        """Forces and fields by depth; where the infill flows; lateral forces; sheared presses."""
        presses, cells, beside, sheared = (read_rows(folder, each) for each in self.stages())
        settings = self.config.beside
        place = f"{settings.x_mm:g} mm along x and {settings.y_mm:g} mm along y" if settings is not None else ""
        tables = (
            _table("presses", "Presses", ("depth_mm", "fz_n", *SKIN, "refused"), presses),
            _table("cells", "Presses above the middle of a cell", ("depth_mm", "fz_n", *INFILL, "refused"), cells),
            _table(
                "flow", "Where the infill begins to flow over a cell's height",
                ("yield_mpa", "depth_mm", "fz_n", *SKIN, "deepest_mm"), flow_rows(presses, cells, self.config),
                note="Empty where it does not, down to the deepest depth that was computed.",
            ),
            _table(
                "beside", f"Presses {place} from the middle of a cell", ("depth_mm", *FORCES, *INFILL, "refused"),
                beside,
            ),
            _table(
                "sheared", "Sheared presses", ("depth_mm", "shear_mm", *FORCES, *SKIN, "infill_shear", "refused"),
                sheared,
            ),
        )  # fmt: skip
        everything = (*presses, *cells, *beside, *sheared)
        return StudyResult(
            headline={f"most_{name}": largest(presses, name) for name in ("fz_n", *SKIN)}
            | {"refused": sum(row["refused"] is not None for row in everything)},
            tables=tuple(table for table in tables if table.rows),
            figures=tuple(_figure(presses, name) for name in ("fz_n", *SKIN)),
            facts={
                "Friction": f"{self.config.friction:g} between indenter and skin",
                "Yield stress of the infill": " / ".join(f"{1000 * each:g}" for each in self.config.infill_yield.each)
                + " kPa (assumed)",
            },
            notes=NOTES,
        )


def read_rows(folder: Path, stage: PiecesStage) -> list[dict[str, Any]]:
    """Rows of all pieces of a stage, in order; a piece that was refused as a whole is a row with the reason."""
    rows, refusals = list[dict[str, Any]](), read_refusals(folder, stage)
    for number, content in enumerate(read_pieces(folder, stage)):
        if content is not None:
            rows += json.loads(content)
            continue
        task = stage.tasks[number]
        assert isinstance(task, LimitPress | CellPress | LimitShear)
        rows.append(case_of(task) | {"refused": refusals.get(number, "no result")})
    return rows


def flow_rows(
    presses: Sequence[Mapping[str, Any]], cells: Sequence[Mapping[str, Any]], config: LimitsConfig
) -> list[dict[str, Cell]]:
    """Where the infill of a whole cell's height begins to flow, for each case and each yield stress."""
    infill, found = config.design.materials.infill, list[dict[str, Cell]]()
    if infill is None:
        return found
    for diameter, skin in dict.fromkeys((row["diameter_mm"], row["skin_mm"]) for row in cells):
        case = {"diameter_mm": diameter, "skin_mm": skin}
        sheared = _path(cells, case, {"least_infill_shear": 0.0, "depth_mm": 0.0, "fz_n": 0.0})
        skins = _path(presses, case, {"depth_mm": 0.0, "skin_stretch": 1.0, "skin_von_mises_mpa": 0.0})
        for stress in config.infill_yield.each:
            row: dict[str, Cell] = {**case, "yield_mpa": stress, "deepest_mm": float(sheared["depth_mm"][-1])}
            at = first_passed(sheared["least_infill_shear"], stress / infill.shear_modulus_mpa)
            if at is not None:
                places = np.arange(len(sheared["depth_mm"]))
                depth, force = (float(np.interp(at, places, sheared[name])) for name in ("depth_mm", "fz_n"))
                row |= {"depth_mm": depth, "fz_n": force}
                if depth <= skins["depth_mm"][-1]:
                    row |= {name: float(np.interp(depth, skins["depth_mm"], skins[name])) for name in SKIN}
            found.append(row)
    return found


def largest(rows: Sequence[Mapping[str, Any]], name: str) -> float | None:
    """Largest value that rows have; None where they have none."""
    return max((row[name] for row in rows if row.get(name) is not None), default=None)


def first_passed(values: Array, level: float) -> float | None:
    """Where a path first reaches a level, in places along it, linear between them; None where it does not.

    Values have the shape (places,), and are below the level at first.
    """
    above = np.flatnonzero(values >= level)
    if len(above) == 0:
        return None
    last = int(above[0])
    if last == 0:
        return 0.0
    return last - 1 + float((level - values[last - 1]) / (values[last] - values[last - 1]))


def _path(rows: Sequence[Mapping[str, Any]], case: Mapping[str, float], rest: Mapping[str, float]) -> dict[str, Array]:
    """Values along a press from rest on, by name, as far as it has them."""
    own = [row for row in rows if row["refused"] is None and all(row[key] == value for key, value in case.items())]
    return {name: np.array([first, *(float(row[name]) for row in own)]) for name, first in rest.items()}


def _resolved(
    config: LimitsConfig, cases: Sequence[tuple[ElastomerDesign, float]], walls: Cells | Beside | None,
    offset_mm: tuple[float, float] | None,
) -> list[CellPress]:  # fmt: skip
    """Presses of each design and diameter with resolved walls; none where none are asked for, or there are no walls."""
    if walls is None or not config.design.has_grid:
        return []
    return [
        CellPress(
            design=design, diameter_mm=diameter, depths_mm=walls.depths_mm, offset_mm=offset_mm,
            friction=config.friction, spacing_mm=walls.spacing_mm, margin_mm=walls.margin_mm,
        )
        for design, diameter in cases
    ]  # fmt: skip


def _sheared(config: LimitsConfig) -> list[LimitShear]:
    sheared = config.sheared
    if sheared is None:
        return []
    return [
        LimitShear(
            design=config.with_skin(sheared.skin_mm), diameter_mm=sheared.diameter_mm, depth_mm=depth, shear_mm=shear,
            friction=config.friction, spacing_mm=sheared.spacing_mm,
        )
        for depth, shear in sheared.paths_mm
    ]  # fmt: skip


def _table(name: str, title: str, names: Sequence[str], rows: Sequence[Mapping[str, Any]], *, note: str = "") -> Table:
    columns = columns_of(("diameter_mm", "skin_mm", *names), HEADS)
    columns = tuple(replace(each, digits=4) if each.name == "yield_mpa" else each for each in columns)
    filled: tuple[Row, ...] = tuple({each.name: row.get(each.name) for each in columns} for row in rows)
    return Table(name=name, title=title, columns=columns, rows=filled, note=note, shown=200)


def _figure(rows: Sequence[Mapping[str, Any]], name: str) -> Figure:
    series = []
    for diameter, skin in dict.fromkeys((row["diameter_mm"], row["skin_mm"]) for row in rows):
        own = [row for row in rows if (row["diameter_mm"], row["skin_mm"]) == (diameter, skin)]
        points = [(float(row["depth_mm"]), float(row[name])) for row in own if row.get(name) is not None]
        series.append(
            Series(name=f"{diameter:g} mm, skin {skin:g}", x=[x for x, _ in points], y=[y for _, y in points])
        )
    drawn = plot_series(
        series, x_title="depth [mm]", y_title=TITLES[name], name=name, label=f"{TITLES[name]} against depth",
        from_zero=name != "skin_stretch",
    )  # fmt: skip
    return Figure(name=name, title=TITLES[name][0].upper() + TITLES[name][1:], svg=drawn)
