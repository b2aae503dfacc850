"""The deformation lattice: nodes on the printed grid planes, box cells between them, stiffness per cell.

Nodes and cells are numbered with x fastest and z slowest: the contact face z = 0 comes first and the base, the plane
z = height, last.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array, Index, Mask
from magicsim.deform.lattice.cell_problem import printed_fields
from magicsim.deform.lattice.hexahedron import CORNERS
from magicsim.deform.lattice.zone import ROUNDING_MM, SAMPLE_MM, Zone, graded_planes
from magicsim.errors import GeometryError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import Dome, HeightMap, flattened
from magicsim.geometry.grid import CellGrid, Planes, lattice_planes, node_spacing_mm, resolve_grid

COARSEST_EDGE, EDGE_STEP = 30.0, 1.15
"""Factor of the spacing at edges at which it is given up to have more planes there, and of one that is tried to the
next: assumed."""
BESIDE_MM = 0.3 + ROUNDING_MM
"""Nodes of the face that are so near to what touches it are moved with it [mm]: assumed."""
FINEST_MM, FINEST_BALL_MM = 0.1, 0.05
"""Smallest spacing that a small zone asks for; below balls of radii under twice the first one it is half of the radius,
not less than the second [mm]: assumed."""
LONG, LEAST_ROUND_MM = 2.0, 1.0
"""Most length of a round object's zone in units of its width, and its least radius [mm]: for others nothing finer was
compared."""
FINEST_ROUND_MM = 0.15
"""Smallest spacing that a round object asks for [mm]: forces of touches of 0.02 mm are 0 to 3 % too large, in up to
3 s (`benchmarks/default_lattice.py`)."""
ROUND_MARGIN, ROUND_DEPTH = 1.0, 0.6
"""Most of `lattice.margin` and `lattice.fine_depth` where cells are finer below a round object, so that fewer around
pay for those below: the far field changes its force by 0.8 % at most then, with a depth of 0.2 by 1.1 %."""
MAX_NODES, MAX_GRADED_NODES = 1_000_000, 170_000
"""Most nodes of the whole lattice, which fills files, and of a graded one, whose solve takes minutes and 8 GB."""


WEIGHT_N_PER_MM3 = 1.12e-5
"""Specific weight of a printed block: 1.145 g/cm3 times gravity, the density of Agilus30."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableTop:
    """A rigid plane on which the block lies loose."""

    friction: float
    """Coulomb's coefficient between block and table."""
    weight_mpa: float
    """Weight of the block over its footprint [MPa]; it rests on the base and does not deform the block."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lattice:
    """Box cells at rest, in the sensor's frame."""

    planes_mm: Planes
    """Increasing node planes along x, y and z [mm]."""
    nodes_mm: Array
    """Rest positions of the nodes, shape (nodes, 3) [mm]."""
    cells: Index
    """Corner nodes in the order of `hexahedron.CORNERS`, shape (cells, 8)."""
    sizes_mm: Array
    """Edges of each cell, shape (cells, 3) [mm]."""
    shear_modulus_mpa: Array
    """Shear modulus mu of each cell, shape (cells,) [MPa]."""
    wall_modulus_mpa: Array
    """Modulus beta of the walls along x, y and z, shape (cells,) [MPa]; 0 where a cell is isotropic."""
    lame_mpa: Array
    """First Lame parameter lambda of each cell, shape (cells,) [MPa]."""
    is_core: Mask
    """Whether a cell's centre lies in the printed core, shape (cells,)."""
    grid: CellGrid | None = None
    """The printed cells; None in a block without."""
    zone: Zone | None = None
    """Where contact is expected and the planes are fine; None is everywhere."""
    is_mirrored: bool = False
    """Whether the planes of smallest x and y are planes of symmetry: the lattice is a quarter of the block."""
    table: TableTop | None = None
    """Table below the base; None where it is bonded."""
    face: Dome | HeightMap | None = None
    """Shape of the contact face; planes and sizes then are those of the box that is mapped. None is flat."""
    wall_buckling_strain: float | None = None
    """Squeeze along a wall from which on it carries no more; None where it does not buckle."""
    coat_n_per_mm: float = 0.0
    """Thickness times shear modulus of the coat on the contact face [N/mm]; 0 where it has none, or no stiffness."""

    def flattened(self, points_mm: Array) -> Array:
        """Points of the block where the box of its planes has them, shape (..., 3) [mm]."""
        return flattened(points_mm, self.face, self.height_mm)

    @property
    def footprint_mm(self) -> tuple[float, float]:
        """Sides along x and y of a face around the origin that reaches as far as its planes [mm]."""
        x, y = (2 * float(np.abs(planes).max()) for planes in self.planes_mm[:2])
        return x, y

    @property
    def height_mm(self) -> float:
        """Height of the block; its plane z = height is the base [mm]."""
        return float(self.planes_mm[2][-1])

    @property
    def smallest_edge_mm(self) -> float:
        """Shortest cell edge [mm]."""
        return float(self.sizes_mm.min())

    @property
    def layer_nodes(self) -> int:
        """Nodes in one z plane."""
        return len(self.planes_mm[0]) * len(self.planes_mm[1])

    @property
    def free_nodes(self) -> int:
        """Nodes that can move: all on a table, else all but the last plane; the first so many."""
        return len(self.nodes_mm) - (self.layer_nodes if self.table is None else 0)

    @property
    def held(self) -> Mask:
        """Displacements of the free nodes that symmetry forbids, shape (free nodes, 3)."""
        held = np.zeros((self.free_nodes, 3), bool)
        if self.is_mirrored:
            row = len(self.planes_mm[0])
            number = np.arange(self.free_nodes) % self.layer_nodes
            held[:, 0], held[:, 1] = number % row == 0, number < row
        return held


def box_lattice(planes_mm: Planes, *, shear_modulus_mpa: float, lame_mpa: float) -> Lattice:
    """A lattice of one material on increasing planes along x, y and z [mm]."""
    x, y, z = (np.asarray(planes, float) for planes in planes_mm)
    nodes = np.stack(np.meshgrid(z, y, x, indexing="ij"), -1)[..., ::-1].reshape(-1, 3)
    number = np.arange(len(nodes)).reshape(len(z), len(y), len(x))
    k, j, i = (axis.ravel() for axis in np.indices((len(z) - 1, len(y) - 1, len(x) - 1)))
    cells = np.stack([number[k + corner[2], j + corner[1], i + corner[0]] for corner in CORNERS], 1)
    sizes = np.stack([np.diff(x)[i], np.diff(y)[j], np.diff(z)[k]], 1)
    return Lattice(
        planes_mm=(x, y, z),
        nodes_mm=np.ascontiguousarray(nodes),
        cells=cells.astype(np.int64),
        sizes_mm=sizes,
        shear_modulus_mpa=np.full(len(cells), float(shear_modulus_mpa)),
        wall_modulus_mpa=np.zeros(len(cells)),
        lame_mpa=np.full(len(cells), float(lame_mpa)),
        is_core=np.zeros(len(cells), bool),
    )


def build_lattice(design: ElastomerDesign, *, zone: Zone | None = None) -> Lattice:
    """The lattice of a design: its planes, the body's stiffness in the skin, the effective stiffness in the core.

    A core cell gets the stiffness of the periodic cell problem even where `lattice.spacing_mm` splits a printed cell or
    the grading joins several: the lattice then resolves the deformation better or worse, not the wall.

    Args:
        design: The block.
        zone: Part of the contact face that can be touched: there are `lattice.cells_across` cells across it, and
            planes spread away from it by `lattice.growth`; None keeps all planes.

    Raises:
        GeometryError: The grid does not fit the block, or there are too many nodes.
    """
    grid = resolve_grid(design)
    if zone is None:
        planes, most = lattice_planes(design, grid), MAX_NODES
    else:
        fine = _fine_enough(design, zone)
        planes = _split_at_edges(_graded(lattice_planes(fine, grid), zone, fine), zone, design)
        most = MAX_GRADED_NODES
    nodes = math.prod(len(each) for each in planes)
    if nodes > most:
        raise GeometryError(
            f"the lattice has {nodes} nodes, at most {most} are allowed: take a larger design.lattice.spacing_mm or "
            "growth, a smaller margin or fine_depth, or a smaller block"
        )
    return replace(lattice_on(planes, design), zone=zone)


def located(planes_mm: Array, places_mm: Array) -> tuple[Index, Array]:
    """Interval of each place along an axis, that at its end of one outside, and how much of it lies before, in 0..1."""
    interval = np.clip(np.searchsorted(planes_mm, places_mm, side="right") - 1, 0, len(planes_mm) - 2)
    return interval, np.clip((places_mm - planes_mm[interval]) / np.diff(planes_mm)[interval], 0, 1)


def lattice_on(planes_mm: Planes, design: ElastomerDesign) -> Lattice:
    """A design's stiffness on given node planes [mm], those between skin and core among them."""
    grid, body = resolve_grid(design), design.materials.body
    lattice = box_lattice(planes_mm, shear_modulus_mpa=body.shear_modulus_mpa, lame_mpa=body.lame_mpa)
    if design.mounting.base == "table":
        weight = WEIGHT_N_PER_MM3 * design.height_mm
        lattice = replace(lattice, table=TableTop(friction=design.mounting.friction, weight_mpa=weight))
    if design.coat is not None:
        lattice = replace(lattice, coat_n_per_mm=design.coat.shear_n_per_mm)
    fields = printed_fields(design, grid)
    if grid is not None and fields is not None:
        core, centres = fields.stiffness, lattice.nodes_mm[lattice.cells].mean(1)
        far = grid.origin_mm + grid.pitch_mm * np.array(grid.counts)
        is_core = ((centres > grid.origin_mm) & (centres < far)).all(1)
        lattice = replace(
            lattice,
            shear_modulus_mpa=np.where(is_core, core.shear_modulus_mpa, lattice.shear_modulus_mpa),
            wall_modulus_mpa=np.where(is_core, core.wall_modulus_mpa, 0.0),
            lame_mpa=np.where(is_core, core.lame_mpa, lattice.lame_mpa),
            is_core=is_core,
            grid=grid,
        )
    if design.face is not None:  # the box is mapped to a curved one, which is free of stress
        lattice = replace(lattice, nodes_mm=np.ascontiguousarray(design.lifted(lattice.nodes_mm)), face=design.face)
    return lattice


def _fine_enough(design: ElastomerDesign, zone: Zone) -> ElastomerDesign:
    """The design with a spacing that a small zone asks for.

    Not below sharp tips and textures: they slide off single nodes of a fine lattice without friction, and its paths
    then do not end.
    """
    options = design.lattice
    if options.cells_across == 0 or not zone.is_blunt:
        return design
    finest = float(np.clip(zone.feature_mm / 2, FINEST_BALL_MM, FINEST_MM))
    # a zone is known to the distance of its points: of balls as small as these the radius says more
    radius = zone.radius_mm if zone.feature_mm > 2 * FINEST_MM else min(zone.radius_mm, zone.feature_mm)
    asked, usual, around = max(2 * radius / options.cells_across, finest), node_spacing_mm(design), {}
    sides = np.subtract(zone.high_mm, zone.low_mm)
    is_round = zone.edges is None and sides.max() <= LONG * sides.min() and zone.feature_mm >= LEAST_ROUND_MM
    if is_round and options.cells_across_round > 0:
        inside = max(radius**2 - 2 * SAMPLE_MM * zone.feature_mm, radius**2 / 4) ** 0.5
        finer = max(2 * inside / options.cells_across_round, FINEST_ROUND_MM)
        if finer < asked:
            asked = finer
            around = {"margin": min(options.margin, ROUND_MARGIN), "fine_depth": min(options.fine_depth, ROUND_DEPTH)}
    if asked >= usual:
        return design
    return design.model_copy(update={"lattice": options.model_copy(update={"spacing_mm": asked, **around})})


def _graded(planes: Planes, zone: Zone, design: ElastomerDesign) -> Planes:
    options, skin = design.lattice, design.skin_mm
    margin = options.margin * float(max(np.diff(planes[axis]).max() for axis in range(3)))
    fine = zone.grown(margin)
    sizes = (*design.footprint_mm, design.height_mm)
    low = (fine.low_mm[0], fine.low_mm[1], 0.0)
    high = (fine.high_mm[0], fine.high_mm[1], options.fine_depth * zone.radius_mm + margin)
    faces = [planes[axis][0] + np.array([skin, sizes[axis] - skin] if design.has_grid else []) for axis in range(3)]
    x, y, z = (
        graded_planes(planes[axis], low[axis], high[axis], options.growth, keep_mm=faces[axis]) for axis in range(3)
    )
    return x, y, z


def _split_at_edges(planes: Planes, zone: Zone, design: ElastomerDesign) -> Planes:
    """Planes with more of them at the edges of what touches, as fine as `edge_nodes` lets them be."""
    edges, options = zone.edges, design.lattice
    if edges is None or options.cells_across == 0:
        return planes
    scale, below = 1.0, zone.grown(BESIDE_MM)
    while scale < COARSEST_EDGE:
        x, y = (edges.split(planes[axis], axis, scale=scale) for axis in range(2))
        counts = [
            int(((each >= low) & (each <= high)).sum())
            for each, low, high in zip((x, y), below.low_mm, below.high_mm, strict=True)
        ]
        if math.prod(counts) <= options.edge_nodes:
            return x, y, edges.split_depth(planes[2], scale=scale)
        scale *= EDGE_STEP
    return planes
