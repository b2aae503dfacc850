"""Infill cells as drawn and as printed: rounded edges, uneven walls, waving planes, missing walls, and inclusions.

Fillets where walls cross round a cell's edges and corners. Neighbouring cells share the waves, so that walls bend with
them and keep their thickness. Where a wall is missing, two cells become one to light: the mesh keeps its vertices and
the number of its triangles, the cell above the wall hangs on the facing vertices of the cell below, and the face of the
cell below stays as a membrane that light does not feel: it tells in which of the two cells a ray is.

Each bubble or flake lies in one cell, at a place in units of it, and clear of its walls and of the others. It moves
with the corners of its cell; its radius shrinks where the cell is squeezed, by the largest compression there, so that
it stays inside, and does not grow.
"""

from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Mask
from magicsim.geometry.flaws import CUTOFF_SKIN_SD, Inclusions, Unevenness
from magicsim.geometry.grid import CellGrid
from magicsim.geometry.mesh import SurfaceMesh, from_manifold

CELL_STREAM, SKIN_STREAM, WALL_STREAM, INCLUSION_STREAM = 0x9E37, 0x5C1F, 0x7047, 0xB0BB
"""Keep a print's random numbers apart from others of that seed."""
WAVES = 48
"""Plane waves of one length and random directions and phases that a field is the sum of: nearly Gaussian."""
CUTOFF_SD = 2.0
"""A wall differs from the drawing by at most so many standard deviations."""
WHOLE = 2**32 - 1
"""Stands for no cell behind a triangle."""
Faces = npt.NDArray[np.int32]
FACET_TOLERANCE = 0.005
"""Largest relative difference of the volume from that of round edges."""
REACH = np.array([0.0, 1.0, np.pi / (2 * np.sqrt(2)), 2 / np.sqrt(3)])
"""Distance of a vertex of a fillet from its axis, in units of the radius: on a face, an edge, a corner. An eighth of a
turn is one facet, and what lies under the facets is what lies under the round."""
APART = 1.02
"""Least distance of two centres in units of the sum of their radii, and of one from a wall in units of its own."""
TRIES = 50
"""Places that are tried for each; one for which a cell has no more room is left out."""
_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)


def cell_mesh(edges_mm: Array, parts: int, radius_mm: float) -> SurfaceMesh:
    """Surface of one cell around its centre, its edges split into parts beside fillets of a radius, 0 for a cuboid."""
    cube = manifold3d.Manifold.cube(tuple(edges_mm), True)
    if radius_mm == 0:
        return from_manifold(cube.refine(parts) if parts > 1 else cube)
    cell, half, steps = from_manifold(cube.refine(parts + 2)), np.asarray(edges_mm) / 2, parts + 2
    line = np.rint((cell.vertices / half + 1) / 2 * steps).astype(int)
    inner = half - radius_mm
    # Places of the mesh lines along an axis: the ends, and the flat part split evenly
    lines = [np.array([-end, *np.linspace(-flat, flat, parts + 1), end]) for end, flat in zip(half, inner, strict=True)]
    places = np.stack([lines[axis][line[:, axis]] for axis in range(3)], 1)
    core = np.clip(places, -inner, inner)
    away = places - core
    reach = radius_mm * REACH[(np.abs(away) > radius_mm / 2).sum(1)] / np.linalg.norm(away, axis=1)
    return SurfaceMesh(vertices=core + reach[:, None] * away, faces=cell.faces)


def cell_volume_mm3(edges_mm: Array, radius_mm: float) -> float:
    """Volume of a cuboid with round edges and corners (Steiner's formula) [mm3]."""
    a, b, c = (float(edge) - 2 * radius_mm for edge in edges_mm)
    r = radius_mm
    return a * b * c + 2 * r * (a * b + b * c + c * a) + np.pi * r**2 * (a + b + c) + 4 / 3 * np.pi * r**3


def facing_vertices(cell: Array, axis: int) -> tuple[Index, Index]:
    """Vertices of a cell on its upper face along an axis, and those opposite them; a printed face is not quite flat."""
    places, rows = cell[:, axis], np.sqrt((len(cell) - 2) / 6)
    slack = np.ptp(places) / (2 * rows)  # half of the way to the next row of vertices
    high, low = np.flatnonzero(places > places.max() - slack), np.flatnonzero(places < places.min() + slack)
    across = np.delete(cell, axis, axis=1)
    opposite = np.linalg.norm(across[high, None] - across[low], axis=2).argmin(1)
    return high, low[opposite]


def printed_cells(vertices: Array, grid: CellGrid, unevenness: Unevenness) -> Array:
    """Vertices of all cells as printed, from those as drawn, cell after cell, shape (vertices, 3) [mm]."""
    if unevenness.is_even:
        return vertices
    random = np.random.default_rng(np.random.SeedSequence([unevenness.seed, CELL_STREAM]))
    centres = np.repeat(grid.centres_mm(), len(vertices) // grid.cell_count, axis=0)
    # A wall takes half of what each of its two cells leaves: independent cells of sqrt(2) sd give it one sd.
    limit = np.sqrt(2) * unevenness.wall_sd_mm
    taken = np.clip(random.standard_normal((grid.cell_count, 3)), -CUTOFF_SD, CUTOFF_SD) * limit
    share = 1 - np.repeat(taken, len(vertices) // grid.cell_count, axis=0) / grid.cell_mm
    waves = _waves(vertices, unevenness.wave_sd_mm, unevenness.wave_length_mm, 3, random)
    printed = np.asarray(centres + share * (vertices - centres) + waves)
    if unevenness.shifts_cells:
        low = grid.origin_mm
        printed += unevenness.shift_mm(vertices, low, low + grid.pitch_mm * grid.counts)
        printed[:, 2] += _skin(vertices, grid, unevenness)
    return printed


def _skin(places: Array, grid: CellGrid, unevenness: Unevenness) -> Array:
    """How far an uneven skin lifts what is drawn at places: all on the lowest faces, nothing above the lowest cells."""
    if unevenness.skin_sd_mm == 0:
        return np.zeros(len(places))
    random = np.random.default_rng(np.random.SeedSequence([unevenness.seed, SKIN_STREAM]))
    limit = CUTOFF_SKIN_SD * unevenness.skin_sd_mm
    rise = _waves(places[:, :2], unevenness.skin_sd_mm, unevenness.skin_length_mm, 1, random)[:, 0]
    below = grid.centres_mm()[0, 2] + grid.cell_mm[2] / 2 - places[:, 2]
    return np.asarray(np.clip(rise, -limit, limit) * np.clip(below / grid.cell_mm[2], 0, 1))


def _waves(places: Array, spread: float, length: float, count: int, random: np.random.Generator) -> Array:
    """Smooth random fields at places in a plane or in space, shape (places, fields), in the unit of their spread."""
    axes = places.shape[1]
    directions = random.standard_normal((count, WAVES, axes))
    directions *= 2 * np.pi / length / np.linalg.norm(directions, axis=2, keepdims=True)
    phases = random.uniform(0, 2 * np.pi, (count, WAVES))
    height = spread * np.sqrt(2 / WAVES)
    sums = [np.cos(places @ directions[field].T + phases[field]).sum(1) for field in range(count)]
    return np.asarray(height * np.stack(sums, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class FusedCells:
    """Connections of cells where walls are missing."""

    pairs: Index
    """Cells below and above each missing wall, shape (walls, 2); no cell is there twice."""
    faces: Faces
    """Triangles of all cells, shape (triangles, 3), collapsed to a point where a membrane belongs to the cell below."""
    closed: Faces
    """Triangles of closed cells, which share a membrane."""
    without_membranes: Faces
    """Triangles of the fused cells, collapsed to points where a wall is missing."""
    beyond: npt.NDArray[np.uint32]
    """Cell above the membrane that a triangle is, or `WHOLE`, shape (triangles,)."""


def draw_fused_cells(share: float, seed: int, grid: CellGrid, cells: SurfaceMesh) -> FusedCells | None:
    """Takes a share of all walls between two cells out of a grid, whose mesh is as drawn; None without any."""
    below, axes = _missing(share, seed, grid)
    if not len(below):
        return None
    above = below + np.cumprod([1, *grid.counts[:2]])[axes]
    count = len(cells.vertices) // grid.cell_count
    one = cells.faces[: len(cells.faces) // grid.cell_count]
    opposite = [facing_vertices(cells.vertices[:count], axis) for axis in range(3)]
    closed = cells.faces.reshape(grid.cell_count, -1, 3).copy()
    beyond = np.full(closed.shape[:2], WHOLE, np.uint32)
    faces, bare = closed.copy(), closed.copy()
    for axis, (high, low) in enumerate(opposite):
        ours = axes == axis
        under, over = below[ours], above[ours]
        hung = np.arange(count) + over[:, None] * count
        hung[:, low] = high + under[:, None] * count
        closed[over] = faces[over] = bare[over] = hung[:, one]
        lower, upper = (np.flatnonzero(np.isin(one, side).all(1)) for side in (high, low))
        beyond[under[:, None], lower] = over[:, None]
        for fused in (faces, bare):
            fused[over[:, None], upper] = fused[over[:, None], upper][..., :1]
        bare[under[:, None], lower] = bare[under[:, None], lower][..., :1]
    return FusedCells(
        pairs=np.stack([below, above], 1), faces=faces.reshape(-1, 3), closed=closed.reshape(-1, 3),
        without_membranes=bare.reshape(-1, 3), beyond=beyond.ravel(),
    )  # fmt: skip


def _missing(share: float, seed: int, grid: CellGrid) -> tuple[Index, Index]:
    """Cells below missing walls and the axes across these, walls in random order, of each cell one at the most."""
    steps = np.cumprod([1, *grid.counts[:2]])
    places = np.stack(np.unravel_index(np.arange(grid.cell_count), grid.counts[::-1]), 1)[:, ::-1]
    cell, axis = np.nonzero(places < np.array(grid.counts) - 1)
    random = np.random.default_rng(np.random.SeedSequence([seed, WALL_STREAM]))
    used, wanted = np.zeros(grid.cell_count, bool), round(share * len(cell))
    missing: list[int] = []
    for wall in random.permutation(len(cell)).tolist():
        if len(missing) == wanted:
            break
        ends = [cell[wall], cell[wall] + steps[axis[wall]]]
        if not used[ends].any():
            used[ends] = True
            missing.append(wall)
    order = np.sort(np.array(missing, np.int64))
    return cell[order], axis[order]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedInclusions:
    """Inclusions in one state of the cells, cell after cell."""

    cell: Index
    """Number of each one's cell, shape (inclusions,)."""
    centres_mm: Array
    """Shape (inclusions, 3), in the sensor's frame [mm]."""
    radii_mm: Array
    """Shape (inclusions,) [mm]."""
    normals: Array
    """Normals of flakes, unit vectors, shape (inclusions, 3); of no meaning for bubbles."""
    is_bubble: Mask

    def air_mm3(self, cells: int) -> Array:
        """Volume of the bubbles in each cell, shape (cells,) [mm3]."""
        volumes = np.where(self.is_bubble, 4 / 3 * np.pi * self.radii_mm**3, 0.0)
        return np.asarray(np.bincount(self.cell, volumes, cells), np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnInclusions:
    """Inclusions of one print."""

    cell: Index
    """Number of each one's cell, in order, shape (inclusions,)."""
    places: Array
    """From -1 to 1 along each edge of the cell, shape (inclusions, 3)."""
    radii_mm: Array
    normals: Array
    """Normals of flakes at rest, shape (inclusions, 3)."""
    is_bubble: Mask
    half_mm: Array
    """Half of a cell's edges as drawn, shape (3,) [mm]."""
    corners: Index
    """Vertices at the corners of a cell, x fastest, shape (8,)."""
    cells: int

    def placed(self, vertices: Array) -> PlacedInclusions:
        """The inclusions in cells with these vertices, cell after cell, shape (vertices, 3) [mm]."""
        cells = vertices.reshape(self.cells, -1, 3)[self.cell][:, self.corners]
        weights, slopes = _trilinear(self.places)
        centres = np.einsum("ic,icd->id", weights, cells)
        # Columns are where the edges of the drawn cell go, per mm of them.
        gradient = np.einsum("ica,icd->ida", slopes, cells) / self.half_mm
        shrunk = np.minimum(np.linalg.svd(gradient, compute_uv=False)[:, -1], 1)
        turned = np.einsum("iad,ia->id", np.linalg.inv(gradient), self.normals)
        return PlacedInclusions(
            cell=self.cell, centres_mm=centres, radii_mm=self.radii_mm * shrunk, is_bubble=self.is_bubble,
            normals=turned / np.linalg.norm(turned, axis=1, keepdims=True),
        )  # fmt: skip


def draw_inclusions(inclusions: Inclusions, grid: CellGrid, cell_vertices: Array) -> DrawnInclusions | None:
    """The bubbles and flakes of a print, None where there are none.

    `cell_vertices` are those of the first cell as drawn, shape (vertices of a cell, 3) [mm].
    """
    if inclusions.is_clean:
        return None
    random = np.random.default_rng(np.random.SeedSequence([inclusions.seed, INCLUSION_STREAM]))
    lowest = cell_vertices.min(0)
    ends = lowest + (cell_vertices.max(0) - lowest) * _CORNERS
    corners = np.linalg.norm(cell_vertices - ends[:, None], axis=2).argmin(1)
    # Corners of rounded cells lie further in.
    half = np.ptp(cell_vertices[corners], axis=0) / 2
    volume = grid.infill_volume_mm3
    kinds = ((True, inclusions.bubbles_per_mm3, inclusions.bubble_radius_mm),
             (False, inclusions.flakes_per_mm3, inclusions.flake_radius_mm))  # fmt: skip
    radii, bubbles = [], []
    for filled, density, (low, high) in kinds:
        radii.append(random.uniform(low, high, random.poisson(density * volume)))
        bubbles.append(np.full(len(radii[-1]), filled))
    radius, is_bubble = np.concatenate(radii), np.concatenate(bubbles)
    cell, directions = random.integers(grid.cell_count, size=len(radius)), random.standard_normal((len(radius), 3))
    tried = random.uniform(-1, 1, (len(radius), TRIES, 3))
    places, kept = _apart(cell, radius, tried, half)
    if not kept.any():
        return None
    order = np.flatnonzero(kept)[np.argsort(cell[kept], kind="stable")]
    normals = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return DrawnInclusions(
        cell=cell[order], places=places[order], radii_mm=radius[order], normals=normals[order],
        is_bubble=is_bubble[order], half_mm=half, corners=corners, cells=grid.cell_count,
    )  # fmt: skip


def _apart(cell: Index, radius: Array, tried: Array, half: Array) -> tuple[Array, Mask]:
    """Places in units of the cell that keep clear of walls and of each other, and which found one; the widest first."""
    places, kept = np.zeros((len(radius), 3)), np.zeros(len(radius), bool)
    inside: dict[int, list[int]] = {}
    for each in np.argsort(-radius, kind="stable").tolist():
        others = inside.setdefault(int(cell[each]), [])
        for place in tried[each] * (1 - APART * radius[each] / half):
            away = np.linalg.norm((places[others] - place) * half, axis=1)
            if (away > APART * (radius[others] + radius[each])).all():
                places[each], kept[each] = place, True
                others.append(each)
                break
    return places, kept


def _trilinear(places: Array) -> tuple[Array, Array]:
    """Weights of a cell's corners, shape (places, 8), and their slopes along the edges, shape (places, 8, 3)."""
    signs = 2 * _CORNERS - 1
    along = (1 + places[:, None] * signs) / 2
    slopes = np.stack([signs[:, axis] / 2 * np.delete(along, axis, axis=2).prod(2) for axis in range(3)], axis=2)
    return along.prod(2), slopes
