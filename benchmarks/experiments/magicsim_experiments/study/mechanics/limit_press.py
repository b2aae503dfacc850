"""Presses of domed indenters that say how hard skin and infill are used: the pieces of the study `limits`."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.models import Config
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.follow import rotation_and_strain
from magicsim.deform.lattice.hexahedron import shape_gradients
from magicsim.deform.lattice.spot import central_lattice, resolved_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import InfillCells, SkinCells, shear_of
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import symmetric_place
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import ObjectConfig, parse_object
from magicsim_experiments.study.protocol import StudyConfig

Length = Annotated[float, Field(gt=0, le=25)]
Depths = Annotated[tuple[Length, ...], Field(min_length=1, max_length=200)]
Friction = Annotated[float, Field(ge=0, le=5)]
Spacing = Annotated[float, Field(ge=0.1, le=5)]
Margin = Annotated[float, Field(ge=0, le=5)]
Stress = Annotated[float, Field(gt=0, le=10)]


class YieldStress(Config):
    """Shear stress at which the infill begins to flow; assumed, with a range."""

    low_mpa: Stress
    mpa: Stress
    high_mpa: Stress

    def _problems(self) -> Iterator[str]:
        if not self.low_mpa <= self.mpa <= self.high_mpa:
            numbers = f"low_mpa = {self.low_mpa:g}, mpa = {self.mpa:g}, high_mpa = {self.high_mpa:g}"
            yield f"{numbers} are not allowed: must not decrease"

    @property
    def each(self) -> tuple[float, float, float]:
        """Lowest, middle and highest [MPa]."""
        return self.low_mpa, self.mpa, self.high_mpa


class Cells(Config):
    """Presses above the middle of a cell with resolved walls, of which a quarter is solved."""

    depths_mm: Depths
    spacing_mm: Spacing = 0.4
    margin_mm: Margin = 0.85


class Beside(Config):
    """Presses beside the middle of a cell with resolved walls, of which the whole block is solved."""

    x_mm: Annotated[float, Field(ge=-3, le=3)]
    y_mm: Annotated[float, Field(ge=-3, le=3)]
    diameters_mm: tuple[Length, ...]
    skins_mm: tuple[Length, ...]
    depths_mm: Depths
    spacing_mm: Spacing = 0.45
    margin_mm: Margin = 0.5


class Sheared(Config):
    """Presses that are then sheared along x."""

    diameter_mm: Length
    skin_mm: Length
    paths_mm: tuple[tuple[Length, Length], ...]
    """Depth and shear of each."""
    spacing_mm: Spacing = 0.5


class LimitsConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["limits"]
    diameters_mm: Annotated[tuple[Length, ...], Field(min_length=1, max_length=20)]
    """Diameters of the domed cylinders."""
    skins_mm: Annotated[tuple[Length, ...], Field(min_length=1, max_length=20)]
    """Thicknesses that the design's skin is given; its core stays."""
    depths_mm: Depths
    """Depths of each press, increasing."""
    friction: Friction = 1.0
    infill_yield: YieldStress
    cells: Cells | None = None
    beside: Beside | None = None
    sheared: Sheared | None = None

    def _problems(self) -> Iterator[str]:
        for name, depths in self.paths_mm.items():
            if any(later <= earlier for earlier, later in pairwise(depths)):
                yield f"{name} = {list(depths)} is not allowed: must increase"

    @property
    def paths_mm(self) -> dict[str, tuple[float, ...]]:
        """Depths of the presses by the key that gives them."""
        more = {"cells": self.cells, "beside": self.beside}
        return {"depths_mm": self.depths_mm} | {
            f"{key}.depths_mm": each.depths_mm for key, each in more.items() if each
        }

    def with_skin(self, skin_mm: float) -> ElastomerDesign:
        """The design with another skin."""
        return ElastomerDesign.model_validate(self.design.model_dump() | {"skin_mm": skin_mm})


def layer_shear(lattice: Lattice, displacements_mm: Array, place_mm: tuple[float, float]) -> Array:
    """Mean shear of each layer of the uppermost infill cube below a place, the one next to the skin first.

    Args:
        lattice: Of a block, from `resolved_lattice`, walls resolved there.
        displacements_mm: Of the nodes, shape (nodes, 3) [mm].
        place_mm: x and y [mm].

    Returns:
        Amounts of shear as `magicsim.deform.strain` has them, shape (layers,); empty without infill.
    """
    grid = lattice.grid
    if grid is None:
        return np.empty(0)
    corners = lattice.nodes_mm[lattice.cells]
    middles = corners.mean(1)
    first = np.floor((np.array(place_mm) - grid.origin_mm[:2]) / grid.pitch_mm[:2])
    centre = grid.origin_mm + (np.array([*first, 0.0]) + 0.5) * grid.pitch_mm
    inside = np.flatnonzero((np.abs(middles - centre) < grid.cell_mm / 2).all(1))
    moved = corners[inside] + displacements_mm[lattice.cells[inside]]
    slopes = shape_gradients(np.full((1, 3), 0.5))[0]  # in the middle of a trilinear cell is the mean of it
    rest, now = (np.einsum("cpi,pk->cik", each, slopes) for each in (corners[inside], moved))
    shear = shear_of(rotation_and_strain(now @ np.linalg.inv(rest))[1])
    volume, depth = lattice.sizes_mm[inside].prod(1), np.round(middles[inside, 2], 9)
    return np.array([np.average(shear[depth == each], weights=volume[depth == each]) for each in np.unique(depth)])


GROWTH = 2.2
"""Ratio of neighbouring node spacings away from resolved walls."""
MOST_SPACING_MM, LEAST_LAYERS = 0.25, 2
"""Largest node spacing at which a skin is told of, and fewest layers of cells across it."""
SHEAR_STEPS = 5
"""Poses along a sheared path after the press."""
QUARTERS = np.array([0.0, 0.0, 4.0])
"""Forces on the whole block in units of those on a quarter; lateral ones cancel."""
Row = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitPress:
    """One domed cylinder, pressed deeper and deeper into the block with its effective core; a quarter is solved."""

    design: ElastomerDesign
    diameter_mm: float
    depths_mm: tuple[float, ...]
    friction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CellPress:
    """One domed cylinder, pressed above the middle of a printed cell or a little beside it, walls resolved below."""

    design: ElastomerDesign
    diameter_mm: float
    depths_mm: tuple[float, ...]
    offset_mm: tuple[float, float] | None
    """Offset of the axis from the cell's middle along x and y [mm]; none is a press of which a quarter is solved."""
    friction: float
    spacing_mm: float
    """Largest node spacing between walls and in the skin [mm]."""
    margin_mm: float
    """Walls are resolved so far around the indenter and so deep below the skin [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitShear:
    """One domed cylinder, pressed and then moved along x under contact, on the block with its effective core."""

    design: ElastomerDesign
    diameter_mm: float
    depth_mm: float
    shear_mm: float
    friction: float
    spacing_mm: float


def case_of(task: LimitPress | CellPress | LimitShear) -> Row:
    """What every row of a piece begins with."""
    return {"diameter_mm": task.diameter_mm, "skin_mm": task.design.skin_mm}


def limit_press(task: LimitPress) -> bytes:
    """Rows of a press as JSON, a row a depth; one that does not converge has no numbers, and says why."""
    dome = _dome(task.diameter_mm)
    zone = contact_zone([place_object(dome, gap_mm=-task.depths_mm[-1])], task.design)
    assert zone is not None  # every depth is above 0
    spacing_mm = min(MOST_SPACING_MM, task.design.skin_mm / LEAST_LAYERS)
    lattice = central_lattice(task.design, zone, spacing_mm=spacing_mm, is_quarter=True)
    solver, skin = _solver(lattice, dome, task.friction), SkinCells.of(task.design, lattice)
    poses = [({"depth_mm": depth}, place_object(dome, gap_mm=-depth)) for depth in task.depths_mm]
    return _solved(solver, case_of(task), poses, lambda state: _forces(state.force_n * QUARTERS) | _skin(state, skin))


def cell_press(task: CellPress) -> bytes:
    """Rows of a press with resolved walls as JSON, a row a depth; one that does not converge says why."""
    dome, (x, y) = _dome(task.diameter_mm), symmetric_place(task.design, "cell")
    spot = Zone(low_mm=(x, y), high_mm=(x, y)).grown(task.diameter_mm / 2)
    is_quarter, offset = task.offset_mm is None, task.offset_mm or (0.0, 0.0)
    lattice = resolved_lattice(
        task.design, spot, margin_mm=task.margin_mm, spacing_mm=task.spacing_mm, growth=GROWTH, mirrored=is_quarter
    )
    poses = [
        ({"depth_mm": depth}, place_object(dome, gap_mm=-depth, x_mm=x + offset[0], y_mm=y + offset[1]))
        for depth in task.depths_mm
    ]

    def measured(state: Deformation) -> Row:
        shear = layer_shear(lattice, state.displacements_mm, (x, y)).tolist()
        found = {"least_infill_shear": min(shear, default=None), "most_infill_shear": max(shear, default=None)}
        return _forces(state.force_n * QUARTERS if is_quarter else state.force_n) | found

    return _solved(_solver(lattice, dome, task.friction), case_of(task), poses, measured)


def limit_shear(task: LimitShear) -> bytes:
    """Rows of a sheared press as JSON, a row a pose; one that does not converge has no numbers, and says why."""
    dome = _dome(task.diameter_mm)
    shears = [task.shear_mm * step / SHEAR_STEPS for step in range(SHEAR_STEPS + 1)]
    poses = [({"shear_mm": shear}, place_object(dome, gap_mm=-task.depth_mm, x_mm=shear)) for shear in shears]
    options = task.design.lattice.model_copy(update={"spacing_mm": task.spacing_mm})
    design = task.design.model_copy(update={"lattice": options})
    lattice = build_lattice(design, zone=contact_zone([pose for _, pose in poses], design))
    skin, infill = SkinCells.of(design, lattice), InfillCells.of(design, lattice)

    def measured(state: Deformation) -> Row:
        shear = float(infill.shear(state).max()) if infill is not None else None
        return _forces(state.force_n) | _skin(state, skin) | {"infill_shear": shear}

    case = case_of(task) | {"depth_mm": task.depth_mm}
    return _solved(_solver(lattice, dome, task.friction), case, poses, measured)


def _solved(
    solver: ContactSolver, case: Row, poses: Sequence[tuple[Row, Indenter]], measured: Callable[[Deformation], Row]
) -> bytes:  # fmt: skip
    """Rows of a path as JSON, until a pose has no valid equilibrium: its row says why."""
    rows: list[Row] = []
    state = None
    for place, pose in poses:
        try:
            state = solver.solve(pose, state)
        except ConvergenceError as error:
            rows.append(case | place | {"refused": str(error)})
            break
        rows.append(case | place | measured(state))
    return json.dumps(rows).encode()


def _forces(force_n: Array) -> Row:
    return {**dict(zip(("fx_n", "fy_n", "fz_n"), force_n.tolist(), strict=True)), "refused": None}


def _skin(state: Deformation, skin: SkinCells) -> Row:
    fields = skin.fields(state)
    return {"skin_stretch": float(fields.stretch.max()), "skin_von_mises_mpa": float(fields.von_mises_mpa.max())}


def _dome(diameter_mm: float) -> ObjectConfig:
    return parse_object(f"domed_cylinder:radius_mm={diameter_mm / 2}")


def _solver(lattice: Lattice, object: ObjectConfig, friction: float) -> ContactSolver:
    return ContactSolver(lattice, friction=friction, point_spacing_mm=point_spacing_mm(object.shape()))
