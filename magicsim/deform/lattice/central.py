"""A lattice that is fine below the middle of the contact face, and what it says of a touch elsewhere.

Cells of the core are homogenised, so that a block looks alike from every point of its face as long as its sides are
far: a touch off the middle deforms it as the same touch in the middle does, moved along. What is left out is that the
sides are nearer there; `tests/unit/deform/test_central.py` bounds it half-way between the middle and the sides. On a
curved face it moves along the face; the slope there, and that the block is thinner, are left out as well.

An object that is its own mirror image in the planes x = 0 and y = 0 needs a quarter of the block.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.lattice.follow import follow_map
from magicsim.deform.lattice.structure import Lattice, lattice_on
from magicsim.deform.lattice.zone import Zone, graded_planes
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import lifted
from magicsim.geometry.grid import split_count
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
        _axis([0.0, size / 2 - skin, size / 2], far + margin, spacing_mm, options.growth)
        for size, far in zip(design.footprint_mm, reach, strict=True)
    )
    deep = options.fine_depth * max(reach) + margin
    z = _axis([0.0, skin, design.height_mm - skin, design.height_mm], deep, spacing_mm, options.growth)
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


def _axis(ends_mm: list[float], fine_to_mm: float, spacing_mm: float, growth: float) -> Array:
    """Planes from the first end to the last, all ends among them, fine up to a distance."""
    ends = np.unique(ends_mm)
    parts = [
        np.linspace(low, high, split_count(high - low, spacing_mm), endpoint=False) for low, high in pairwise(ends)
    ]
    return graded_planes(np.concatenate([*parts, ends[-1:]]), 0.0, fine_to_mm, growth, keep_mm=ends)
