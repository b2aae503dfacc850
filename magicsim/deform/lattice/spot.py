"""Lattices that are fine below one spot of the contact face: homogenised below the middle, or with walls of their own.

**`central_lattice`.** Cells of the core are homogenised, so that a block looks alike from every point of its face as
long as its sides are far: a touch off the middle deforms it as the same touch in the middle does, moved along. What is
left out is that the sides are nearer there; `tests/unit/deform/lattice/test_spot.py` bounds it half-way between the
middle and the sides. On a curved face it moves along the face; the slope there, and that the block is thinner, are left
out as well.

An object that is its own mirror image in the planes x = 0 and y = 0 needs a quarter of the block.

**`resolved_lattice`.** An indenter as small as a printed cell feels single walls, and the effective stiffness of
`build_lattice` smears them: the cone of a durometer is 0.8 mm wide. Every wall in a box below the spot is two cells
thick, with the printed plane in its middle; outside the box the lattice is the usual one, coarser and coarser.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.deform.lattice.follow import follow_map
from magicsim.deform.lattice.structure import Lattice, lattice_on
from magicsim.deform.lattice.zone import Zone, graded_planes
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import lifted
from magicsim.geometry.grid import CellGrid, lattice_planes, resolve_grid, split_count
from magicsim.geometry.indenter import Indenter

QUARTERS = 4
"""Quarters of a block; a lattice of one of them stands for all."""
MIRROR_TOLERANCE_MM = 1e-6
"""Difference of distances up to which an object is its own mirror image [mm]."""
MIRROR_POINTS = 400
"""Points at which that is looked at."""


def central_lattice(design: ElastomerDesign, zone: Zone, *, spacing_mm: float, is_quarter: bool) -> Lattice:
    """A lattice whose planes lie evenly below a zone about the middle, and spread beyond it.

    The printed planes between cells are none of its planes; those between skin and core are.

    Args:
        design: The block.
        zone: What is touched; as far to each side of the middle as on its farther side.
        spacing_mm: Largest node spacing below the zone [mm].
        is_quarter: Whether only the quarter of positive x and y is kept, its inner faces planes of symmetry.

    Raises:
        GeometryError: The grid does not fit the block.
    """
    options, skin = design.lattice, design.skin_mm if design.has_grid else 0.0
    margin = options.margin * spacing_mm
    reach = [max(-low, high) for low, high in zip(zone.low_mm, zone.high_mm, strict=True)]
    x, y = (
        _graded_axis([0.0, size / 2 - skin, size / 2], far + margin, spacing_mm, options.growth)
        for size, far in zip(design.footprint_mm, reach, strict=True)
    )
    deep = options.fine_depth * max(reach) + margin
    z = _graded_axis([0.0, skin, design.height_mm - skin, design.height_mm], deep, spacing_mm, options.growth)
    if not is_quarter:
        x, y = (np.concatenate([-half[:0:-1], half]) for half in (x, y))
    return replace(lattice_on((x, y, z), design), zone=zone, is_mirrored=is_quarter)


def is_mirror_image(indenter: Indenter) -> bool:
    """Whether an object is the same in the planes x = 0 and y = 0, as far as points near its top can tell."""
    random, size = np.random.default_rng(0), 2 * max(abs(indenter.top_mm()), 1.0)
    points = indenter.pose.position_mm * [0, 0, 1] + random.uniform(-3 * size, 3 * size, (MIRROR_POINTS, 3))
    own = indenter.distance(points)[0]
    mirrored = (indenter.distance(points * sign)[0] for sign in ([-1, 1, 1], [1, -1, 1]))
    return all(float(np.abs(each - own).max()) < MIRROR_TOLERANCE_MM for each in mirrored)


def displaced_elsewhere(
    lattice: Lattice, displacements_mm: Array, points_mm: Array, place_mm: tuple[float, float]
) -> Array:
    """Displacements that a touch at a place gives to points, from those of the same touch in the middle.

    Args:
        lattice: From `central_lattice`.
        displacements_mm: Of its nodes, shape (nodes, 3) [mm].
        points_mm: Rest positions, shape (points, 3) [mm].
        place_mm: x and y of the touch [mm].

    Returns:
        Shape (points, 3) [mm]; points farther away than the lattice reaches move as its side does.
    """
    offset, sign = lattice.flattened(points_mm) - np.array([*place_mm, 0.0]), np.ones((len(points_mm), 3))
    if lattice.is_mirrored:
        sign[:, :2] = np.where(offset[:, :2] < 0, -1.0, 1.0)
    folded = lifted(offset * sign, lattice.face, lattice.height_mm)
    return np.asarray((follow_map(lattice, folded).displaced(displacements_mm) - folded) * sign)


def _graded_axis(ends_mm: list[float], fine_to_mm: float, spacing_mm: float, growth: float) -> Array:
    """Planes from the first end to the last, all ends among them, fine up to a distance."""
    ends = np.unique(ends_mm)
    parts = [
        np.linspace(low, high, split_count(high - low, spacing_mm), endpoint=False) for low, high in pairwise(ends)
    ]
    return graded_planes(np.concatenate([*parts, ends[-1:]]), 0.0, fine_to_mm, growth, keep_mm=ends)


ROUNDING_MM = 1e-9
"""Slack of a plane's place [mm]."""


def resolved_lattice(
    design: ElastomerDesign, spot: Zone, *, margin_mm: float, spacing_mm: float, growth: float, mirrored: bool = False,
    homogenised: bool = False,
) -> Lattice:  # fmt: skip
    """The lattice of a design with its walls resolved below a spot of the contact face.

    Args:
        design: The block.
        spot: What is touched.
        margin_mm: Walls are resolved so far around the spot and so deep below the skin [mm]; cells that the box cuts
            are resolved whole.
        spacing_mm: Largest node spacing in the box, between walls and in the skin [mm].
        growth: Ratio of neighbouring spacings outside.
        mirrored: Only the quarter beyond the spot's centre, which has to be a place of symmetry.
        homogenised: Keep the effective stiffness of the core on the same planes.

    Raises:
        GeometryError: The grid does not fit the block.
    """
    grid, fine = resolve_grid(design), spot.grown(margin_mm)
    box = ((fine.low_mm[0], fine.high_mm[0]), (fine.low_mm[1], fine.high_mm[1]), (0.0, design.skin_mm + margin_mm))
    centre = (*spot.centre_mm, None) if mirrored else (None, None, None)
    x, y, z = (
        _axis(planes, low, high, _Walls(design, grid, axis), _Spacing(spacing_mm, growth, middle))
        for axis, (planes, (low, high), middle) in enumerate(
            zip(_printed_planes(design, grid), box, centre, strict=True)
        )
    )
    lattice = lattice_on((x.planes_mm, y.planes_mm, z.planes_mm), design)
    lattice = replace(lattice, zone=spot, is_mirrored=mirrored)
    infill = design.materials.infill
    if grid is None or infill is None or homogenised:
        return lattice
    resolved = _everywhere(x.is_resolved, y.is_resolved, z.is_resolved) & lattice.is_core
    is_infill = _everywhere(x.is_infill, y.is_infill, z.is_infill)
    body = design.materials.body
    shear = np.where(is_infill, infill.shear_modulus_mpa, body.shear_modulus_mpa)
    lame = np.where(is_infill, infill.lame_mpa, body.lame_mpa)
    return replace(
        lattice,
        shear_modulus_mpa=np.where(resolved, shear, lattice.shear_modulus_mpa),
        lame_mpa=np.where(resolved, lame, lattice.lame_mpa),
        wall_modulus_mpa=np.where(resolved, 0.0, lattice.wall_modulus_mpa),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Axis:
    planes_mm: Array
    is_resolved: Mask
    """Which intervals lie in the box, shape (planes - 1,)."""
    is_infill: Mask
    """Which of them lie between two walls, shape (planes - 1,)."""


@dataclass(frozen=True, slots=True)
class _Spacing:
    """How fine an axis is, and where it begins."""

    fine_mm: float
    growth: float
    middle_mm: float | None
    """A plane of symmetry that is the first one; None keeps both sides."""


@dataclass(frozen=True, slots=True)
class _Walls:
    """The walls across one axis."""

    design: ElastomerDesign
    grid: CellGrid | None
    axis: int

    def faces_mm(self, low: float, high: float) -> Array:
        """Faces of the walls in an interval, and of those that bound the core the inner ones [mm]."""
        if self.grid is None:
            return np.empty(0)
        printed = self.grid.planes_mm(self.axis)
        faces = np.concatenate([printed[:-1] + self.design.wall_mm / 2, printed[1:] - self.design.wall_mm / 2])
        return np.asarray(faces[(faces > low) & (faces < high)])

    def are_between(self, places_mm: Array) -> Mask:
        """Whether infill may be at each place, shape (places,)."""
        if self.grid is None:
            return np.zeros(len(places_mm), bool)
        pitch = self.grid.pitch_mm[self.axis]
        from_wall = (places_mm - self.grid.origin_mm[self.axis]) % pitch
        return np.asarray(np.abs(from_wall - pitch / 2) < self.grid.cell_mm[self.axis] / 2)


def _printed_planes(design: ElastomerDesign, grid: CellGrid | None) -> tuple[Array, ...]:
    """Middle planes of the walls, and the outer faces."""
    unsplit = design.lattice.model_copy(update={"spacing_mm": None})
    return lattice_planes(design.model_copy(update={"lattice": unsplit}), grid)


def _axis(printed_mm: Array, low_mm: float, high_mm: float, walls: _Walls, spacing: _Spacing) -> _Axis:
    """Planes of one axis: divided between the printed planes around `low_mm` and `high_mm`, graded outside."""
    first = max(int(np.searchsorted(printed_mm, low_mm + ROUNDING_MM, side="right")) - 1, 0)
    last = min(int(np.searchsorted(printed_mm, high_mm - ROUNDING_MM, side="left")), len(printed_mm) - 1)
    low, high = printed_mm[first], printed_mm[last]
    middle = [] if spacing.middle_mm is None else [spacing.middle_mm]
    fixed = _distinct(np.concatenate([printed_mm[first : last + 1], walls.faces_mm(low, high), middle]))
    fine = [np.linspace(a, b, split_count(b - a, spacing.fine_mm), endpoint=False) for a, b in pairwise(fixed)]
    planes = np.concatenate([printed_mm[:first], *fine, printed_mm[last:]])
    if spacing.middle_mm is not None:
        planes = planes[planes > spacing.middle_mm - ROUNDING_MM]
    skin = walls.design.skin_mm
    faces = np.array([printed_mm[0] + skin, printed_mm[-1] - skin]) if walls.grid is not None else np.empty(0)
    planes = graded_planes(planes, max(low, planes[0]), high, spacing.growth, keep_mm=faces[faces > planes[0]])
    middles = (planes[1:] + planes[:-1]) / 2
    return _Axis(
        planes_mm=planes,
        is_resolved=(middles > low) & (middles < high),
        is_infill=walls.are_between(middles),
    )


def _distinct(places_mm: Array) -> Array:
    """Places in order, those that agree but for rounding once [mm]."""
    ordered = np.sort(places_mm)
    return np.asarray(ordered[np.diff(ordered, prepend=-np.inf) > ROUNDING_MM])


def _everywhere(x: Mask, y: Mask, z: Mask) -> Mask:
    """Cells whose intervals all hold, shape (cells,), x fastest."""
    return np.asarray((z[:, None, None] & y[:, None] & x).ravel())
