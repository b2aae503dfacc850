"""The result of a solve: where the lattice is, and what the object does to it; and a lattice that is only displaced.

**What touches.** Below a flat face, and beside its edges, a lattice cannot lie flat: it is pressed at some of its
points and is apart by hundredths of a millimetre between them, the less the finer it is. What is that near, with points
that touch all around it, touches. At the border of a contact with a round object the face leaves it at a tangent, which
nodes h apart show no better than by h^2 / 8R, the height of an arc over its chord: what is nearer than `BORDER` of that
touches.
"""

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Index, Mask
from magicsim.deform.contact.face import ContactFace, contact_face
from magicsim.deform.lattice.core_failure import CoreState
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.lattice.relaxation import RelaxationState
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import TableMemory
from magicsim.geometry.pose import Pose
from magicsim.notebook import figures_table

WAVE_MM = 0.02
"""Gap up to which a face waves below flat objects [mm]: measured at the middle of a box on cells of 0.1 to 0.9 mm."""
ONE_SIDED = 0.5
"""Length of the mean direction to the points that touch around another, from which they lie to one side of it:
assumed."""
LEAST_AROUND = 4
"""Fewest points around another: assumed."""
BORDER = 0.95
"""Share of an arc's height over its chord up to which a border's points touch: measured on balls of 2, 4 and 8 mm
radius, 0.1 to 1 mm deep, on cells of 0.18 to 0.9 mm, against the border on cells of 0.06 to 0.25 mm, where the gap is
proportional to the distance from it to the power 3/2."""
SMOOTH_RAD = 0.46
"""Turn of an object's normal over a facet above which it has an edge or a texture there, and no radius; that of a ball
of 2 mm over a cell of 0.9 mm is 0.45."""
FLAT_RAD = 1e-3
"""Turn below which it is flat: assumed."""


def border_gaps_mm(lattice: Lattice, face: ContactFace, points_mm: Array, normals: Array) -> Array:
    """Gap up to which each point touches beside a round object, shape (points,) [mm]; 0 where that has no radius.

    Points and the object's normals next to them are of shape (points, 3).
    """
    first = np.flatnonzero(np.diff(face.facet, prepend=-1))
    count = np.diff(first, append=len(face.facet))
    edge = _edges_mm(lattice, face.facet[first])

    def spread(values: Array) -> Array:
        mean = np.add.reduceat(values, first) / count[:, None]
        return np.asarray(np.maximum.reduceat(np.linalg.norm(values - np.repeat(mean, count, 0), axis=1), first))

    turn = spread(normals) / np.maximum(spread(points_mm), 1e-12) * edge
    return np.repeat(np.where((turn > FLAT_RAD) & (turn <= SMOOTH_RAD), BORDER * turn * edge / 8, 0.0), count)


def touching_points(
    lattice: Lattice, face: ContactFace, points_mm: Array, gap_mm: Array, *, gap_limits_mm: Array | float
) -> Mask:
    """Which points at places of shape (points, 3) touch, shape (points,).

    They do so by themselves up to a limit of their gap, one for all or shape (points,), or with others around them.
    """
    touching = gap_mm <= gap_limits_mm
    apart = np.flatnonzero(~touching & (gap_mm <= WAVE_MM))
    own = points_mm[touching, :2]
    if len(apart) == 0 or len(own) < LEAST_AROUND:
        return touching
    around = cKDTree(own).query_ball_point(points_mm[apart, :2], _edges_mm(lattice, face.facet[apart]))
    is_between = np.zeros(len(apart), bool)
    for number, near in enumerate(around):
        if len(near) >= LEAST_AROUND:
            directions = own[near] - points_mm[apart[number], :2]
            directions /= np.maximum(np.linalg.norm(directions, axis=1), 1e-12)[:, None]
            is_between[number] = np.linalg.norm(directions.mean(0)) < ONE_SIDED
    touching[apart[is_between]] = True
    return touching


def _edges_mm(lattice: Lattice, facets: Index) -> Array:
    """Longer edge of some facets at rest, of the shape of their numbers [mm]."""
    x, y = (np.diff(planes) for planes in lattice.planes_mm[:2])
    return np.asarray(np.maximum(x[facets % len(x)], y[facets // len(x)]))


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveFigures:
    """How trustworthy a deformation is."""

    iterations: int
    """Newton iterations of a solve or along a path, cut-backs included; 0 where nothing was solved."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    max_penetration_mm: float
    """Deepest contact point inside the object [mm]."""
    force_balance: float
    """|contact force + reaction of the base| / |contact force|; 0 without contact."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathFigures(SolveFigures):
    """Cost of a solve or a path."""

    cutbacks: int = 0
    """Load steps that had to be halved."""
    restarts: int = 0
    """Paths that were begun again from rest, with longer steps."""
    shifted: int = 0
    """Iterations whose matrix was not positive definite before a multiple of the spring Laplacian was added."""
    rungs: tuple[str, ...] = ()
    """Rungs on which it stands, see `magicsim.deform.solve.ladder`."""
    unknowns: int
    """Displacement unknowns."""
    converged: bool = True
    """Always true: a solve that is not valid raises."""


def figures_last(result: SolveFigures) -> dict[str, Any]:
    """All fields of a result: its own first, the figures that it shares with others after them."""
    values = asdict(result)
    return {name: values[name] for name in type(result).__slots__} | values


TOUCHING_GAP_MM = 0.01
"""Up to this distance from the object a point of the face is rendered as touching [mm]: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """Where a touched lattice is said to be; nothing is known of forces, and no equilibrium is claimed."""

    displacements_mm: Array
    """Displacements of the nodes, shape (nodes, 3) [mm]."""

    @property
    def is_rest(self) -> bool:
        """Whether nothing touches: never."""
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Deformation(PathFigures):
    """One quasi-static equilibrium of the lattice, valid by construction."""

    displacements_mm: Array
    """Displacements of the nodes, shape (nodes, 3) [mm]."""
    pressure_mpa: Array
    """Volumetric stress lambda (J - 1) of each cell, negative in compression, shape (cells,) [MPa]."""
    contact_points_mm: Array
    """Deformed quadrature points of the contact face, shape (points, 3) [mm]."""
    anchors_mm: Array
    """Where friction holds them, in the object's frame, shape (points, 3) [mm]."""
    contact_pressure_mpa: Array
    """Contact pressure per rest area at them, zero where nothing touches, shape (points,) [MPa]."""
    contact_traction_mpa: Array
    """Traction of the object per rest area at them, pressure and friction, shape (points, 3) [MPa]."""
    is_slipping: Mask
    """Which of them touch and slide, their friction at its limit, shape (points,); none without friction."""
    contact_gap_mm: Array
    """Signed distance to the object at them, infinite without an object, shape (points,) [mm]."""
    touches_within_mm: Array
    """Distance up to which they touch, shape (points,) [mm]; at least their own where they do."""
    relaxation: RelaxationState | None = None
    """Memory of a rate-dependent body; None in the long term."""
    linearisation: Linearisation | None = None
    """Where the body's stiffness was taken last: what saves the next step of the path a factorisation."""
    pose: Pose | None = None
    """The object's pose; None when it cannot touch."""
    force_n: Array
    """Force of the object on the sensor, shape (3,) [N]."""
    torque_nmm: Array
    """Torque of that force about the origin, shape (3,) [N mm]."""
    contact_area_mm2: float
    """Deformed area of the points that touch [mm2]."""
    table: TableMemory | None = None
    """Memory of friction below a block on a table; None at rest and where the base is bonded."""
    core: CoreState | None = None
    """Memory of a core that fails; None at rest and where it cannot."""

    def __repr__(self) -> str:
        """Nodes, force and the figures that say how far it can be trusted; no arrays."""
        if self.is_rest:
            return f"Deformation(at rest, {len(self.displacements_mm)} nodes)"
        force = ", ".join(f"{each:.3f}" for each in self.force_n)
        return (
            f"Deformation({len(self.displacements_mm)} nodes, force ({force}) N, area {self.contact_area_mm2:.2f} mm2, "
            f"penetration {1000 * self.max_penetration_mm:.2f} um, {self.iterations} iterations)"
        )

    def _repr_html_(self) -> str:
        """Table of the figures, for notebooks."""
        moved = float(np.linalg.norm(self.displacements_mm, axis=1).max())
        figures: dict[str, object] = {
            "force [N]": ", ".join(f"{each:.4f}" for each in self.force_n),
            "torque [N mm]": ", ".join(f"{each:.4f}" for each in self.torque_nmm),
            "contact area [mm2]": float(self.contact_area_mm2),
            "largest displacement [mm]": moved,
            "largest penetration [mm]": float(self.max_penetration_mm),
            "smallest Jacobian": float(self.min_jacobian),
            "force balance": float(self.force_balance),
            "iterations": self.iterations,
            "unknowns": self.unknowns,
        }
        return figures_table("Deformation", figures)

    @property
    def is_rest(self) -> bool:
        """Whether nothing touches."""
        return self.pose is None

    @classmethod
    def rest(cls, lattice: Lattice, face: ContactFace | None = None) -> Self:
        """The undeformed lattice, with the default contact points where no others are given."""
        points = (face or contact_face(lattice)).positions(lattice.nodes_mm)
        return cls(
            displacements_mm=np.zeros_like(lattice.nodes_mm),
            pressure_mpa=np.zeros(len(lattice.cells)),
            contact_points_mm=points,
            anchors_mm=points,
            contact_pressure_mpa=np.zeros(len(points)),
            contact_traction_mpa=np.zeros_like(points),
            is_slipping=np.zeros(len(points), bool),
            contact_gap_mm=np.full(len(points), np.inf),
            touches_within_mm=np.zeros(len(points)),
            force_n=np.zeros(3),
            torque_nmm=np.zeros(3),
            contact_area_mm2=0.0,
            max_penetration_mm=0.0,
            min_jacobian=1.0,
            force_balance=0.0,
            iterations=0,
            unknowns=3 * lattice.free_nodes,
        )
