"""How alike the units of a kind are: their faces, touched until a threshold of force, printed against moulded."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field
from scipy.interpolate import interpn

from magicsim.arrays import Array
from magicsim.config.models import Config
from magicsim.deform.indentation.press import follow
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim_experiments.study.mechanics.surfaces import UnitShape, depth_at, fitted_surface, touched_heights_mm
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import (
    Column,
    Figure,
    Row,
    Study,
    StudyConfig,
    StudyResult,
    Table,
    columns_of,
)
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals
from magicsim_experiments.study.study_file import named_table

Spread = Annotated[float, Field(ge=0, le=5)]
Share = Annotated[float, Field(gt=0, le=0.98)]


class UnitTolerances(Config):
    """Standard deviations between units of one kind; assumed."""

    thickness_sd_mm: Spread
    """Standard deviation of the height of the block [mm]."""
    slope_sd_deg: Annotated[float, Field(ge=0, le=10)]
    """Standard deviation of the slope of the face along each axis [degrees]."""
    wave_sd_mm: Spread
    """Standard deviation of what is left of the face's shape beside that [mm]."""
    wave_length_mm: Annotated[float, Field(ge=1, le=100)] = 12.0
    """Length of its waves [mm]."""
    stiffness_sd: Annotated[float, Field(ge=0, le=0.3)] = 0.03
    """Standard deviation of the factor on the moduli."""


class Probe(Config):
    """What touches the units."""

    threshold_n: Annotated[float, Field(gt=0, le=20)] = 0.2
    """Normal force at which a touch ends [N]."""
    repeat_sd_mm: Annotated[float, Field(ge=0, le=1)] = 0.01
    """Standard deviation of its place along z [mm]; assumed."""
    step_mm: Annotated[float, Field(gt=0, le=1)] = 0.01
    """Steps in which it advances [mm]; assumed."""


class ManufacturingConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["manufacturing"]
    moulded_design: ElastomerDesign
    """The moulded gel that the design is compared with; a file may give the name of a design preset."""
    object: ObjectConfig
    """What touches."""
    units: Annotated[int, Field(ge=2, le=50)] = 6
    draws: Annotated[int, Field(ge=1, le=1000)] = 10
    """Sets of units that are drawn: intervals are over them, matrices are of the first."""
    touches: Annotated[int, Field(ge=50, le=10_000)] = 400
    """Random touches of each unit."""
    place_share: Share = 0.9
    """Part of the face along each axis that is touched."""
    probe: Probe = Probe()
    printed: UnitTolerances
    moulded: UnitTolerances
    depths_mm: Annotated[tuple[Annotated[float, Field(gt=0, le=5)], ...], Field(min_length=2, max_length=20)]
    """Depths at which presses are solved, increasing; the last one's force has to pass the threshold."""
    places_across: Annotated[int, Field(ge=2, le=7)] = 3
    """Places along each axis, from the middle of the face to the end of what is touched, at which they are solved."""

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The moulded design put in place."""
        return data | {"moulded_design": named_table(data.get("moulded_design", "gelsight-type"), "design", folder)}

    def _problems(self) -> Iterator[str]:
        if any(later <= earlier for earlier, later in pairwise(self.depths_mm)):
            yield f"depths_mm = {list(self.depths_mm)} is not allowed: must increase"


THICKER_MM = 0.3
"""By how much the block is thicker whose touch says what thickness does [mm]."""
SHOWN = 41
"""Places along each axis at which surfaces are compared."""
KINDS = ("printed", "moulded")
NOTES = (
    "Tolerances, the probe's step and its error are assumed: the matrix says what they would do to units, not what six "
    "printed units were like.",
    "How deep a touch goes at the threshold is solved on the nominal blocks, from the middle of the face outwards, and "
    "for one thicker block; stiffness scales the force.",
    "Errors are mean absolute differences of the fitted surfaces over what is touched; on the diagonal a unit is "
    "touched twice, at other places.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchCurve:
    """Presses at one place."""

    design: ElastomerDesign
    object: ObjectBase
    place_mm: tuple[float, float]
    depths_mm: tuple[float, ...]


def touch_curve(task: TouchCurve) -> bytes:
    """Normal force at each depth [N], as JSON."""
    x, y = task.place_mm
    steps = [
        (place_object(task.object, gap_mm=-depth, x_mm=x, y_mm=y, design=task.design), np.inf)
        for depth in task.depths_mm
    ]
    found = follow(task.design, steps, [0.0] * len(steps), friction=0.0, tolerance_mm=0.002, progress=None)
    return json.dumps([each.force_n[2] for each in found.history]).encode()


class Manufacturing(Study):
    """The study `manufacturing`."""

    settings = ManufacturingConfig
    config: ManufacturingConfig

    def __init__(self, config: ManufacturingConfig) -> None:
        super().__init__(config)
        moulded = config.moulded_design.model_dump() | {"footprint_mm": config.design.footprint_mm}
        self.designs = {"printed": config.design, "moulded": ElastomerDesign.model_validate(moulded)}
        tasks = []
        for design in self.designs.values():
            thicker = ElastomerDesign.model_validate(design.model_dump() | {"core_mm": design.core_mm + THICKER_MM})
            tasks += [self._task(design, place) for place in self._places()] + [self._task(thicker, (0.0, 0.0))]
        self.touches = PiecesStage(name="touches", function=touch_curve, tasks=tasks, seconds=6.0)

    def refuse(self) -> None:
        """Refuses curved faces."""
        if any(design.face is not None for design in self.designs.values()):
            raise ConfigError("study 'manufacturing' needs flat faces: design.face is set")

    def stages(self) -> Sequence[PiecesStage]:
        """Presses at places of the face."""
        return [self.touches]

    def conclude(self, folder: Path) -> StudyResult:
        """Matrices of errors between units of each kind, and what their means say."""
        depths = self._threshold_depths(folder)
        tables, rows, series = [], list[Row](), []
        for kind in KINDS:
            drawn = [self._errors(kind, depths[kind], draw) for draw in range(self.config.draws)]
            matrix = drawn[0]
            tables.append(_matrix_table(kind, matrix))
            rows.append({"kind": kind, **_summary(drawn), "depth_at_threshold_mm": float(depths[kind][1][0])})
            others = matrix.copy()
            np.fill_diagonal(others, np.nan)
            series.append(
                Series(
                    name=kind, x=list(range(1, len(matrix) + 1)), y=np.nanmean(others, axis=1).tolist(),
                    low=np.nanmin(others, axis=1).tolist(), high=np.nanmax(others, axis=1).tolist(),
                )
            )  # fmt: skip
        picture = plot_series(
            series, x_title="unit", y_title="mean difference from the other units [mm]", name="units",
            label="Mean difference of each unit from the others",
        )  # fmt: skip
        summary = Table(
            name="kinds", title="Printed against moulded", columns=columns_of(rows[0], {}, digits=4), rows=tuple(rows),
            note=f"Means over {self.config.draws} draws of all units; low and high hold nine of ten of them.",
        )  # fmt: skip
        return StudyResult(
            headline={
                f"{row['kind']}_{key}": row[key] for row in rows for key in ("self_repeat_mm", "between_units_mm")
            },
            tables=(summary, *tables),
            figures=(Figure(name="units", title="Differences between units", svg=picture),),
            facts={
                "Touches": f"{self.config.touches} of each unit, until {self.config.probe.threshold_n:g} N",
                "Units": f"{self.config.units} of each kind",
            },
            notes=NOTES,
        )

    def _places(self) -> list[tuple[float, float]]:
        """Where presses are solved: a quarter of what is touched, x fastest, the middle first [mm]."""
        x, y = (
            np.linspace(0, self.config.place_share * size / 2, self.config.places_across)
            for size in self.config.design.footprint_mm
        )
        return [(float(each), float(other)) for other in y for each in x]

    def _task(self, design: ElastomerDesign, place_mm: tuple[float, float]) -> TouchCurve:
        return TouchCurve(design=design, object=self.config.object, place_mm=place_mm, depths_mm=self.config.depths_mm)

    def _threshold_depths(self, folder: Path) -> dict[str, tuple[float, Array]]:
        """Change of the depth with thickness, and depth at the threshold at each place [mm], by kind."""
        refusals = read_refusals(folder, self.touches)
        if refusals:
            raise ConfigError(next(iter(refusals.values())))
        curves = [np.array(json.loads(each)) for each in read_pieces(folder, self.touches) if each is not None]
        threshold, depths = self.config.probe.threshold_n, np.array(self.config.depths_mm)
        weakest = min(float(curve[-1]) for curve in curves)
        if weakest < 1.3 * threshold:  # a stiffness of the unit of 1 / 1.3 still reaches it
            raise ConfigError(
                f"depths_mm = {self.config.depths_mm[-1]:g} at most is too little: the force is {weakest:.3g} N there, "
                f"and probe.threshold_n = {threshold:g} needs 1.3 times as much"
            )
        reached = np.array([depth_at(threshold, depths, curve) for curve in curves])
        return {
            kind: ((own[-1] - own[0]) / THICKER_MM, own[:-1])
            for kind, own in zip(KINDS, np.split(reached, len(KINDS)), strict=True)
        }

    def _errors(self, kind: str, depths: tuple[float, Array], draw: int) -> Array:
        """Mean absolute difference between surfaces of units of one draw, shape (units, units) [mm]."""
        config, number = self.config, KINDS.index(kind)
        tolerances: UnitTolerances = getattr(config, kind)
        half = np.array(config.design.footprint_mm) * config.place_share / 2
        grid = np.stack(np.meshgrid(*(np.linspace(-each, each, SHOWN) for each in half)), -1).reshape(-1, 2)
        surfaces = []
        for unit in range(config.units):
            random = np.random.default_rng([config.seed, number, draw, unit])
            shape = drawn_unit(tolerances, random)
            for _ in range(2):
                places = random.uniform(-half, half, (config.touches, 2))
                depth = self._depth(places, depths, shape)
                heights = touched_heights_mm(
                    shape, places, depth, random, repeat_sd_mm=config.probe.repeat_sd_mm, step_mm=config.probe.step_mm
                )
                surfaces.append(fitted_surface(places, heights)(grid))
        first, second = np.array(surfaces[::2]), np.array(surfaces[1::2])
        return np.asarray(np.abs(first[:, None] - second[None]).mean(-1))

    def _depth(self, places_mm: Array, depths: tuple[float, Array], unit: UnitShape) -> Array:
        """Depth of the face at the threshold at any places of a unit, shape (places,) [mm]."""
        count, by_thickness, known = self.config.places_across, *depths
        share = np.abs(places_mm) / (np.array(self.config.design.footprint_mm) * self.config.place_share / 2)
        depth = interpn((np.linspace(0, 1, count),) * 2, known.reshape(count, count).T, share)
        depth += by_thickness * unit.height_mm
        return np.asarray(depth * unit.stiffness ** (-2 / 3))  # force^(2/3) grows with depth


def _summary(drawn: Sequence[Array]) -> dict[str, float]:
    """Means of matrices of errors on and off their diagonals, with the range of nine draws of ten [mm]."""
    repeat = np.array([np.diag(matrix).mean() for matrix in drawn])
    between = np.array([matrix[~np.eye(len(matrix), dtype=bool)].mean() for matrix in drawn])
    low, high = np.quantile(between, [0.05, 0.95])
    return {
        "self_repeat_mm": float(repeat.mean()), "between_units_mm": float(between.mean()), "low_mm": float(low),
        "high_mm": float(high),
    }  # fmt: skip


def drawn_unit(tolerances: UnitTolerances, random: np.random.Generator) -> UnitShape:
    """A unit drawn from its tolerances."""
    slopes = np.tan(np.radians(random.normal(0, tolerances.slope_sd_deg, 2)))
    height, wave, stiffness = random.normal(
        0, [tolerances.thickness_sd_mm, tolerances.wave_sd_mm, tolerances.stiffness_sd]
    )
    return UnitShape(
        height_mm=float(height), slope=tuple(slopes.tolist()), wave_mm=float(wave),
        wave_length_mm=tolerances.wave_length_mm, wave_phases=tuple(random.uniform(0, 2 * np.pi, 4).tolist()),
        stiffness=float(np.exp(stiffness)),
    )  # fmt: skip


def _matrix_table(kind: str, matrix: Array) -> Table:
    names = [f"unit_{number}_mm" for number in range(1, len(matrix) + 1)]
    columns = (Column(name="unit", digits=0), *columns_of(names, {}, digits=4))
    return Table(
        name=f"errors_{kind}", title=f"Errors between {kind} units", columns=columns,
        rows=tuple({"unit": k, **dict(zip(names, row.tolist(), strict=True))} for k, row in enumerate(matrix, 1)),
        note="Mean absolute difference of the surface of a unit (row) from that of another (column).",
    )  # fmt: skip
