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

from dataclasses import replace
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
ROUNDING_MM = 1e-9
"""Slack of a plane's place [mm]."""


def central_lattice(design: ElastomerDesign, zone: Zone, *, spacing_mm: float, is_quarter: bool) -> Lattice:
    """A lattice whose planes lie evenly below a zone about the middle, and spread beyond it.

    The printed planes between cells are none of its planes; those between skin and core are. The zone counts as far to
    each side of the middle as on its farther side, and below it nodes are at most so far apart [mm]. A quarter is that
    of positive x and y, its inner faces planes of symmetry.

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
    """Displacements [mm] that a touch at x and y gives to points, from those of the same touch in the middle.

    Points have rest positions of shape (points, 3) [mm]; farther away than a `central_lattice` reaches they move as its
    side does.
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


def resolved_lattice(
    design: ElastomerDesign, spot: Zone, *, margin_mm: float, spacing_mm: float, growth: float, mirrored: bool = False,
    homogenised: bool = False,
) -> Lattice:  # fmt: skip
    """The lattice of a design with its walls resolved below a spot of the contact face that is touched.

    They are so by a margin around the spot and below the skin [mm]; cells that this box cuts are resolved whole. In it
    nodes are at most a spacing apart [mm], outside spacings grow by a ratio. A mirrored lattice is the quarter beyond
    the spot's centre, a place of symmetry; a homogenised one keeps the effective stiffness of the core on its planes.

    Raises:
        GeometryError: The grid does not fit the block.
    """
    grid, fine = resolve_grid(design), spot.grown(margin_mm)
    unsplit = design.lattice.model_copy(update={"spacing_mm": None})
    printed = lattice_planes(design.model_copy(update={"lattice": unsplit}), grid)
    box = ((fine.low_mm[0], fine.high_mm[0]), (fine.low_mm[1], fine.high_mm[1]), (0.0, design.skin_mm + margin_mm))
    centre = [(low + high) / 2 if mirrored else None for low, high in zip(spot.low_mm, spot.high_mm, strict=True)]
    axes = [
        _resolved_axis(design, grid, axis, (printed[axis], *box[axis]), middle, spacing_mm, growth)
        for axis, middle in enumerate([*centre, None])
    ]
    (x, *_), (y, *_), (z, *_) = axes
    lattice = replace(lattice_on((x, y, z), design), zone=spot, is_mirrored=mirrored)
    infill = design.materials.infill
    if grid is None or infill is None or homogenised:
        return lattice
    inside, between = [], []
    for axis, (planes, low, high) in enumerate(axes):
        middles, pitch = (planes[1:] + planes[:-1]) / 2, grid.pitch_mm[axis]
        from_wall = (middles - grid.origin_mm[axis]) % pitch
        inside.append((middles > low) & (middles < high))
        between.append(np.abs(from_wall - pitch / 2) < grid.cell_mm[axis] / 2)
    is_resolved, is_infill = _everywhere(*inside) & lattice.is_core, _everywhere(*between)
    body = design.materials.body
    shear = np.where(is_infill, infill.shear_modulus_mpa, body.shear_modulus_mpa)
    lame = np.where(is_infill, infill.lame_mpa, body.lame_mpa)
    return replace(
        lattice,
        shear_modulus_mpa=np.where(is_resolved, shear, lattice.shear_modulus_mpa),
        lame_mpa=np.where(is_resolved, lame, lattice.lame_mpa),
        wall_modulus_mpa=np.where(is_resolved, 0.0, lattice.wall_modulus_mpa),
    )


def _resolved_axis(
    design: ElastomerDesign,
    grid: CellGrid | None,
    axis: int,
    box: tuple[Array, float, float],
    middle_mm: float | None,
    spacing_mm: float,
    growth: float,
) -> tuple[Array, float, float]:
    """Planes of one axis, divided between the printed ones around a box and graded outside, and where the box ends.

    `box` has the middle planes of the walls and outer faces, and the ends of what has to be fine [mm]. A plane of
    symmetry, where there is one, is the first plane.
    """
    printed, low_mm, high_mm = box
    first = max(int(np.searchsorted(printed, low_mm + ROUNDING_MM, side="right")) - 1, 0)
    last = min(int(np.searchsorted(printed, high_mm - ROUNDING_MM, side="left")), len(printed) - 1)
    low, high = printed[first], printed[last]
    walls, skins = np.empty(0), np.empty(0)
    if grid is not None:  # faces of the walls, of those that bound the core the inner ones
        middles, half, skin = grid.planes_mm(axis), design.wall_mm / 2, design.skin_mm
        walls = np.concatenate([middles[:-1] + half, middles[1:] - half])
        skins = np.array([printed[0] + skin, printed[-1] - skin])
    middle = [] if middle_mm is None else [middle_mm]
    places = np.concatenate([printed[first : last + 1], walls[(walls > low) & (walls < high)], middle])
    places = np.sort(places)
    fixed = places[np.diff(places, prepend=-np.inf) > ROUNDING_MM]  # those that agree but for rounding once
    fine = [np.linspace(a, b, split_count(b - a, spacing_mm), endpoint=False) for a, b in pairwise(fixed)]
    planes = np.concatenate([printed[:first], *fine, printed[last:]])
    if middle_mm is not None:
        planes = planes[planes > middle_mm - ROUNDING_MM]
    return graded_planes(planes, max(low, planes[0]), high, growth, keep_mm=skins[skins > planes[0]]), low, high


def _everywhere(x: Mask, y: Mask, z: Mask) -> Mask:
    """Cells whose intervals all hold, shape (cells,), x fastest."""
    return np.asarray((z[:, None, None] & y[:, None] & x).ravel())
