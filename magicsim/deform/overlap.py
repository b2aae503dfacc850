"""Whether an object lies inside the deformed block, told by its own surface and not by the contact points.

Contact holds at the points of the face (`face`): what is smaller than the distance between them may pass through it
and touch none. Here points of the object's surface, its tips and edges among them, are measured against the face as the
solver interpolates it.
"""

import atexit
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array
from magicsim.deform.contact.face import MAX_POINTS, ContactFace, axis_weights
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.edges import paired_sides, triangle_normals
from magicsim.deform.lattice.structure import Lattice, located
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.shapes.solids import Shape

UNSEEN_MM = 0.05
"""Deepest place of an object inside the block where no contact point near it presses [mm]: balls whose radius is twice
the distance of the contact points, as the points are chosen, reach 0.045 mm between four of them and press hardly yet.
Objects of smaller features get no farther than these."""
EDGE_SHARE = 0.4
"""Deepest place inside where points press around it, in units of the node spacing there: a face bends between its nodes
only so far around edges and tips. Measured at depths up to 0.9 mm with nodes 0.93 mm apart: balls of 0.5 to 4 mm 0.003,
edges of punches 0.11, corners of boxes 0.19, cones of 60, 30 and 20 degrees 0.08, 0.22 and 0.34."""
MOST_EXTENTS = 2.5
"""Deepest press in units of the object's largest extent: the face closes above a ball on nothing. Balls pressed by 2.5
diameters were the deepest that had an equilibrium; deeper ones end, after minutes, without."""
STRETCH_DEPTH, MOST_STRETCHED = 4.0, 1.0
"""Depth in radii over which the face around a buried ball is stretched by one more of its length, and the node spacing
that a stretched face may have, in radii of the ball: one that is wider slides off it node by node, and its path does
not end. Measured on a ball of 0.2 mm radius with nodes 0.11 mm apart (stretched by 1.5 at two radii and by 2 at four,
the deepest that was solved) and on one of 0.1 mm. Up to its diameter any ball may be pressed."""
FOLLOWED_MM = 0.25
"""Radius from which that rule does not hold: a ball of 0.5 mm is pressed 1.4 mm deep with nodes 0.8 mm apart."""
SAMPLE_MM = 0.05
"""Spacing of the face's samples near the object [mm]: a face that bends with a radius of a tenth of a millimetre is
met to 0.003 mm."""
SIDE_SAMPLE_MM, MOST_SIDE_SAMPLES = 0.1, 300
"""Distance of the points along the sides of triangles [mm], and their largest number along one."""
FLAT_COSINE = 0.995
"""Between the normals on both sides of a side from which nothing stands out there: they turn by 0.1."""
MOST_SAMPLES = 200
"""Along each axis: below an object as wide as the block samples are farther apart, as its contact points are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Inside:
    """Points of an object's surface inside a block."""

    points_mm: Array
    """In the sensor's frame, shape (points, 3) [mm]."""
    depth_mm: Array
    """Their distances to the face along its normal, or to a side of the block that is nearer, positive, shape (points,)
    [mm]."""
    feet_mm: Array
    """The places of the deformed face nearest to them, shape (points, 3) [mm]."""
    rest_mm: Array
    """Those places at rest, x and y, shape (points, 2) [mm]."""


def burial_fault(lattice: Lattice, indenter: Indenter) -> str | None:
    """Why an object that touches is pressed too deep for any equilibrium, or for its lattice; None where it is not."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    reach = np.array([indenter.shape.support_mm(axis) for axis in axes])
    extent, depth = float((reach[:3] + reach[3:]).max()), indenter.depth_mm(lattice.face, lattice.footprint_mm)
    if depth <= MOST_EXTENTS * extent * (1 + 1e-9):
        spacing = min(float(np.diff(planes).min()) for planes in lattice.planes_mm[:2])
        radius = extent / 2
        most = max(extent, STRETCH_DEPTH * radius * (MOST_STRETCHED * radius / spacing - 1))
        if depth <= most or spacing > extent or radius >= FOLLOWED_MM:  # where a ball between the nodes lies tells
            return None
        return (
            f"the object is pressed {depth:.3g} mm deep and measures {extent:.3g} mm: the face stretches around it to "
            f"{spacing * (1 + depth / (STRETCH_DEPTH * radius)):.2g} mm between nodes, wider than it can follow; "
            f"at most {most:.2g} mm deep, or an object of at least {extent * depth / most:.3g} mm"
        )
    return (
        f"the object is pressed {depth:.3g} mm deep and measures {extent:.3g} mm: the face would close above it; at "
        f"most {MOST_EXTENTS:g} times its size is allowed, or an object of at least {depth / MOST_EXTENTS:.2g} mm"
    )


def overlap_fault(lattice: Lattice, face: ContactFace, state: Deformation, indenter: Indenter) -> str | None:
    """Why a state is no answer: the object lies inside the block; None where it does not."""
    inside = points_inside(lattice, state.displacements_mm, indenter)
    unseen = min(UNSEEN_MM, indenter.shape.feature_mm)
    chosen = inside.depth_mm > unseen
    if not chosen.any():
        return None
    depth, rest, feet = inside.depth_mm[chosen], inside.rest_mm[chosen], inside.feet_mm[chosen]
    # Distances of the node planes on both sides of each place.
    intervals = [
        np.diff(planes)[located(planes, places)[0]]
        for planes, places in zip(lattice.planes_mm, rest.T[:2], strict=False)
    ]
    spacing = np.max(intervals, axis=0)
    pressing = state.contact_points_mm[state.contact_pressure_mpa > 0]
    is_felt = np.zeros(len(depth), bool)
    if len(pressing) > 0:
        is_felt = cKDTree(pressing).query(feet)[0] <= spacing
    limit = np.where(is_felt, np.maximum(unseen, EDGE_SHARE * spacing), unseen)
    worst = int(np.argmax(depth - limit))
    if depth[worst] <= limit[worst]:
        return None
    x, y, z = inside.points_mm[chosen][worst].tolist()
    place = f"the object lies {depth[worst]:.2g} mm inside the block at ({x:.3g}, {y:.3g}, {z:.3g}) mm"
    if is_felt[worst]:
        return (
            f"{place}: at most {limit[worst]:.2g} mm is allowed around an edge or a tip, {EDGE_SHARE:g} of the node "
            f"spacing of {spacing[worst]:.2g} mm there; press less deep, blunt it, or set a smaller lattice.spacing_mm"
        )
    nearest = int(cKDTree(state.contact_points_mm).query(feet[worst])[1])
    between = float(np.sqrt(face.area_mm2[nearest]))
    return (
        f"{place}, and no contact point near it presses: they are {between:.2g} mm apart there and find tips and balls "
        f"with radii from {smallest_radius_mm(between):.2g} mm on{_remedy(indenter.shape.feature_mm, spacing[worst])}"
    )


def smallest_radius_mm(point_spacing_mm: float) -> float:
    """Radius from which a ball that is `UNSEEN_MM` inside reaches a contact point wherever it stands [mm].

    In the middle of four points, half a diagonal h away from each, a cap of height t and radius (h^2 + t^2) / 2t does.
    """
    return (point_spacing_mm**2 / 2 + UNSEEN_MM**2) / (2 * UNSEEN_MM)


def points_inside(lattice: Lattice, displacements_mm: Array, indenter: Indenter) -> Inside:
    """The points of an object's surface that lie inside a block which its contact has deformed.

    What stands beside the block is not inside it, however high.
    """
    moved = displacements_mm[: lattice.layer_nodes]
    face = lattice.nodes_mm[: lattice.layer_nodes] + moved
    points = _near(indenter, face.min(0), face.max(0))
    if len(points) == 0:
        return Inside(points_mm=points, depth_mm=np.empty(0), feet_mm=points, rest_mm=points[:, :2])
    drift = np.abs(moved).max(0)
    places = [
        _places(planes, points[:, axis].min() - drift[axis], points[:, axis].max() + drift[axis])
        for axis, planes in enumerate(lattice.planes_mm[:2])
    ]
    (x, x_slope), (y, y_slope) = (axis_weights(*each) for each in zip(lattice.planes_mm[:2], places, strict=True))
    grid = face.reshape(y.shape[1], x.shape[1], 3)
    samples, along_x, along_y = (
        np.einsum("yj,jic,xi->yxc", one, grid, other, optimize=True).reshape(-1, 3)
        for one, other in ((y, x), (y, x_slope), (y_slope, x))
    )
    nearest = np.asarray(cKDTree(samples, balanced_tree=False, compact_nodes=False).query(points)[1])
    away, along = points - samples[nearest], np.stack([along_x[nearest], along_y[nearest]], axis=1)
    rest = np.stack([places[0][nearest % len(x)], places[1][nearest // len(x)]], axis=1)
    inward = np.cross(along[:, 0], along[:, 1])
    depth = np.einsum("qi,qi->q", away, inward) / np.linalg.norm(inward, axis=1)
    beside = np.einsum("qi,qai->qa", away, along) / np.einsum("qai,qai->qa", along, along)
    step = [places[0][1] - places[0][0], places[1][1] - places[1][0]]
    place = rest + np.clip(beside, np.negative(step), step)
    sides = [planes[-1] - place[:, axis] for axis, planes in enumerate(lattice.planes_mm[:2])]
    if not lattice.is_mirrored:  # planes of symmetry are no sides
        sides += [place[:, axis] - planes[0] for axis, planes in enumerate(lattice.planes_mm[:2])]
    depth = np.minimum(depth, np.min(sides, axis=0))
    below = np.flatnonzero(depth > 0)
    return Inside(points_mm=points[below], depth_mm=depth[below], feet_mm=samples[nearest[below]], rest_mm=rest[below])


@lru_cache(maxsize=8)
def surface_points(shape: Shape) -> Array:
    """Points of a solid's surface, its corners, tips and edges among them, in its own frame, shape (points, 3) [mm].

    Vertices of its triangles, and points along those of their sides across which the surface turns.
    """
    mesh = shape.mesh()
    (normal, _), (start, end, one, other) = triangle_normals(mesh), paired_sides(mesh)
    length = np.linalg.norm(end - start, axis=1)
    chosen = (np.einsum("si,si->s", normal[one], normal[other]) < FLAT_COSINE) & (length > 2 * SIDE_SAMPLE_MM)
    parts = np.minimum(np.ceil(length[chosen] / SIDE_SAMPLE_MM).astype(int), MOST_SIDE_SAMPLES)
    which = np.repeat(np.arange(len(parts)), parts - 1)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(parts - 1) - (parts - 1), parts - 1) + 1) / parts[which]
    return np.concatenate([mesh.vertices, start[chosen][which] + share[:, None] * (end - start)[chosen][which]])


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(surface_points.cache_clear)


def _near(indenter: Indenter, low: Array, high: Array) -> Array:
    """Points of the object above the lowest place of the face and within its sides, shape (points, 3) [mm]."""
    if indenter.top_mm() <= low[2]:
        return np.empty((0, 3))
    points = indenter.pose.to_sensor(surface_points(indenter.shape))
    is_within = ((points[:, :2] >= low[:2]) & (points[:, :2] <= high[:2])).all(axis=1)
    return np.asarray(points[is_within & (points[:, 2] > low[2])])


def _places(planes: Array, low: float, high: float) -> Array:
    """Places on the part of an axis that can come near an object [mm]."""
    reach = float(np.diff(planes).min())
    first, last = np.clip([low - reach, high + reach], planes[0], planes[-1])
    return np.linspace(first, last, int(np.clip(np.ceil((last - first) / SAMPLE_MM), 2, MOST_SAMPLES)) + 1)


def _remedy(feature_mm: float, spacing_mm: float) -> str:
    """The node spacing at which points find a feature, where it is a finer one than there is."""
    squared = 2 * (2 * UNSEEN_MM * feature_mm - UNSEEN_MM**2)
    needed = MAX_POINTS * float(np.sqrt(max(squared, 0.0)))
    return f"; lattice.spacing_mm = {needed:.2g} finds this one" if 0 < needed < spacing_mm else ""
