"""The printed block as closed meshes: the body with its skin, and the infill cells inside it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import manifold3d
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Mask
from magicsim.errors import GeometryError
from magicsim.geometry.design import FACET_MM, ElastomerDesign
from magicsim.geometry.grid import CellGrid, resolve_grid, split_count
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.printed_cells import (
    FACET_TOLERANCE,
    DrawnInclusions,
    FusedCells,
    cell_mesh,
    cell_volume_mm3,
    draw_fused_cells,
    draw_inclusions,
    printed_cells,
)

EDGES = ((0, 1), (1, 2), (2, 0))
FACE_EDGE_MM = 0.5
"""Length to which the edges of the block are split [mm]: fine enough to bend around a fingertip-sized object.
Diagonals of the triangles inside a face are up to twice as long."""
VOLUME_TOLERANCE = 1e-6
ON_FACE_MM, LIFTED_MM = 1e-9, 1e-6
"""Height over the contact face up to which vertices count as on it; with a curved face rounding is larger [mm]."""
CURVED_TOLERANCE = 5e-3
"""Tolerance of a block with a curved face, whose triangles cut its corners."""
VOLUME_STEPS = 2000
SLACK = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Elastomer:
    """Closed meshes of a design. Walls and skin are what lies in `body` and outside `infill`."""

    design: ElastomerDesign
    grid: CellGrid | None
    body: SurfaceMesh
    """Outer surface of the block."""
    infill: SurfaceMesh | None
    """All infill cells, disjoint, x-fastest; cell of a triangle is `triangle // triangles_per_cell`."""
    triangles_per_cell: int
    inclusions: DrawnInclusions | None = None
    """Bubbles and flakes in the cells."""
    fused: FusedCells | None = None
    """How cells hang together to light where walls are missing; None where none is."""
    drawn_cell_mm: Array | None = None
    """Vertices of one cell about its middle as drawn, shape (vertices of a cell, 3) [mm], where a print shifts its
    cells; None where the first one stands for all."""

    @property
    def boxed_cells(self) -> SurfaceMesh:
        """The infill as its box has it; `GeometryError` without a grid."""
        if self.infill is None:
            raise GeometryError("cell_mm = 0: a block without a grid has no cells")
        if self.design.face is None:
            return self.infill
        return SurfaceMesh(vertices=self.design.flattened(self.infill.vertices), faces=self.infill.faces)

    @property
    def is_face(self) -> npt.NDArray[np.bool_]:
        """Body vertices on the contact face, shape (body vertices,)."""
        slack = ON_FACE_MM if self.design.face is None else LIFTED_MM
        return np.asarray(self.design.flattened(self.body.vertices)[:, 2] < slack)


@lru_cache(maxsize=2)
def build_elastomer(design: ElastomerDesign, *, facet_mm: float = FACET_MM) -> Elastomer:
    """Builds the meshes of a design and checks them against the closed form.

    The edges of the contact face are split to `facet_mm`; cells no larger than this stay whole.

    `GeometryError` where the grid does not fit, or a mesh is not watertight or has the wrong volume. Two are kept, for
    the episodes of one printed unit: the waves of its walls take a second.
    """
    grid = resolve_grid(design)
    body = _block(design, facet_mm)
    _check("body", body, float(np.prod([*design.footprint_mm, design.height_mm])))
    body = _lifted(body, design)
    if design.face is not None:
        _check("body", body, block_volume_mm3(design), CURVED_TOLERANCE)
    if grid is None:
        return Elastomer(design=design, grid=None, body=body, infill=None, triangles_per_cell=0)
    radius_mm = design.unevenness.crossing_radius_mm
    cell = cell_mesh(grid.cell_mm, subdivision(design, grid, facet_mm), radius_mm)
    first = np.arange(grid.cell_count, dtype=np.int32) * len(cell.vertices)
    infill = SurfaceMesh(
        vertices=(grid.centres_mm()[:, None] + cell.vertices).reshape(-1, 3),
        faces=(first[:, None, None] + cell.faces).reshape(-1, 3),
    )
    volume_mm3 = grid.cell_count * cell_volume_mm3(grid.cell_mm, radius_mm)
    _check("infill", infill, volume_mm3, FACET_TOLERANCE if radius_mm > 0 else VOLUME_TOLERANCE)
    drawn = infill.vertices[: len(cell.vertices)]
    inclusions = draw_inclusions(design.inclusions, grid, drawn)
    fused = draw_fused_cells(design.unevenness.torn_share, design.unevenness.seed, grid, infill)
    infill = _lifted(replace(infill, vertices=printed_cells(infill.vertices, grid, design.unevenness)), design)
    return Elastomer(
        design=design, grid=grid, body=body, infill=infill, triangles_per_cell=len(infill.faces) // grid.cell_count,
        inclusions=inclusions, fused=fused,
        drawn_cell_mm=drawn - grid.centres_mm()[0] if design.unevenness.shifts_cells else None,
    )  # fmt: skip


def _block(design: ElastomerDesign, facet_mm: float) -> SurfaceMesh:
    width, length = design.footprint_mm
    block = manifold3d.Manifold.cube((width, length, design.height_mm))
    edge = max(min(FACE_EDGE_MM, design.skin_mm), 0.25)
    mesh = from_manifold(block.translate((-width / 2, -length / 2, 0)).refine_to_length(edge))
    return refined_face(mesh, mesh.vertices[:, 2] < ON_FACE_MM, int(np.ceil(edge / facet_mm - SLACK)))


def _lifted(mesh: SurfaceMesh, design: ElastomerDesign) -> SurfaceMesh:
    return mesh if design.face is None else SurfaceMesh(vertices=design.lifted(mesh.vertices), faces=mesh.faces)


def block_volume_mm3(design: ElastomerDesign) -> float:
    """Volume of a block, its cells included: the integral of its height by midpoints [mm3]."""
    x, y = (size * ((np.arange(VOLUME_STEPS) + 0.5) / VOLUME_STEPS - 0.5) for size in design.footprint_mm)
    rise = np.mean([design.rise_mm(np.stack([x, np.full(VOLUME_STEPS, each)], -1)).mean() for each in y[::10]])
    return float(np.prod(design.footprint_mm) * (design.height_mm - rise))


def subdivision(design: ElastomerDesign, grid: CellGrid, facet_mm: float = FACET_MM) -> int:
    """Parts into which the edges of an infill cell are split: as many as the lattice has cells along a pitch.

    At least two, so that a pressed cell can bulge and its walls bend, unless the cells are no larger than the facets;
    no shorter than `FACET_MM`, since below the skin a face's finer dents are gone.
    """
    least = 1 if max(grid.pitch_mm) <= facet_mm else 2
    spacing = max(design.lattice.spacing_mm or np.inf, FACET_MM)
    return max(least, *(split_count(pitch, min(spacing, pitch)) for pitch in grid.pitch_mm.tolist()))


def _check(name: str, mesh: SurfaceMesh, volume_mm3: float, tolerance: float = VOLUME_TOLERANCE) -> None:
    if not mesh.is_watertight():
        raise GeometryError(f"the {name} mesh is not watertight")
    error = mesh.volume_mm3() / volume_mm3 - 1
    if abs(error) > tolerance:
        off = f"{error:+.2g} off the closed form {volume_mm3:.6g} mm3"
        raise GeometryError(f"the {name} mesh has volume {mesh.volume_mm3():.6g} mm3, {off}")


def refined_face(mesh: SurfaceMesh, is_face: Mask, parts: int) -> SurfaceMesh:
    """A closed mesh with every edge of one face divided into equal parts, while the rest of it stays as it is.

    Around what presses, the face bends over tenths of a millimetre, and each flat triangle would be a facet of its own
    to the light. Every triangle of the face becomes a triangular lattice of smaller ones; triangles that stand on its
    rim become fans over the divided edge, so that the mesh stays closed. The vertices of `mesh` come first.

    Triangles beside the face have two of its vertices at most.
    """
    if parts == 1:
        return mesh
    faces = mesh.faces.astype(np.int64)
    off = (~is_face[faces]).sum(1)
    whole, rim, others = faces[off == 0], faces[off == 1], faces[off > 1]
    edges = np.unique(np.sort(whole[:, EDGES].reshape(-1, 2), axis=1), axis=0)
    keys, count = edges[:, 0] * len(mesh.vertices) + edges[:, 1], len(mesh.vertices)

    def between(start: Index, end: Index) -> Index:
        """Vertices along edges of the face, their ends included, shape (edges, parts + 1)."""
        low, high = np.minimum(start, end), np.maximum(start, end)
        number = np.searchsorted(keys, low * len(mesh.vertices) + high)
        inner = count + number[:, None] * (parts - 1) + np.arange(parts - 1)
        inner = np.where((start < end)[:, None], inner, inner[:, ::-1])
        return np.concatenate([start[:, None], inner, end[:, None]], axis=1)

    # where the lattice's points lie, in steps from the first corner towards the second and the third
    steps = [(i, j) for j in range(parts + 1) for i in range(parts + 1 - j)]
    place = {step: number for number, step in enumerate(steps)}
    inside = [step for step in steps if min(*step, parts - sum(step)) > 0]
    first_inside = count + len(edges) * (parts - 1)
    lattice = np.empty((len(whole), len(steps)), np.int64)
    a, b, c = whole.T
    for number in range(parts + 1):
        lattice[:, place[number, 0]] = between(a, b)[:, number]
        lattice[:, place[0, number]] = between(a, c)[:, number]
        lattice[:, place[parts - number, number]] = between(b, c)[:, number]
    lattice[:, [place[step] for step in inside]] = (
        first_inside + np.arange(len(whole))[:, None] * len(inside) + np.arange(len(inside))
    )
    small = [
        (place[i, j], place[i + 1, j], place[i, j + 1]) for i, j in steps if i + j < parts
    ] + [
        (place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]) for i, j in steps if i + j < parts - 1
    ]  # fmt: skip

    share = np.arange(1, parts) / parts
    one, other = mesh.vertices[edges].transpose(1, 0, 2)
    along = one[:, None] + share[:, None] * (other - one)[:, None]
    weights = np.array([(parts - i - j, i, j) for i, j in inside]).reshape(-1, 3) / parts
    within = np.einsum("sk,tkc->tsc", weights, mesh.vertices[whole])
    return SurfaceMesh(
        vertices=np.concatenate([mesh.vertices, along.reshape(-1, 3), within.reshape(-1, 3)]),
        faces=np.concatenate(
            [others, lattice[:, small].reshape(-1, 3), _fans(rim, is_face, between)]
        ).astype(np.int32),
    )  # fmt: skip


def _fans(rim: Index, is_face: Mask, between: Callable[[Index, Index], Index]) -> Index:
    """Triangles beside the face, each from its corner off the face over its divided edge, shape (triangles, 3)."""
    apex = np.argmin(is_face[rim], axis=1)
    turned = np.take_along_axis(rim, (apex[:, None] + np.arange(3)) % 3, axis=1)
    chain = between(turned[:, 1], turned[:, 2])
    tips = np.repeat(turned[:, :1], chain.shape[1] - 1, axis=1)
    return np.stack([tips, chain[:, :-1], chain[:, 1:]], axis=-1).reshape(-1, 3)
