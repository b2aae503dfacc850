"""The result of a solve: where the lattice is, and what the object does to it; and a lattice that is only displaced."""

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import ContactFace, contact_face
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.lattice.relaxation import RelaxationState
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import TableMemory
from magicsim.geometry.pose import Pose
from magicsim.notebook import figures_table


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
    """What a solve or a path took."""

    cutbacks: int
    """Load steps that had to be halved."""
    restarts: int
    """Parts that were begun again from rest, with longer steps and then with shorter ones."""
    shifted: int
    """Iterations whose matrix was not positive definite before a multiple of the spring Laplacian was added."""
    rungs: tuple[str, ...]
    """What it took beyond the ordinary way, see `magicsim.deform.solve.ladder`."""
    unknowns: int
    """Displacement unknowns."""
    converged: bool
    """Always true: a solve that is not valid raises."""


def figures_last(result: SolveFigures) -> dict[str, Any]:
    """All fields of a result: its own first, the figures that it shares with others after them."""
    values = asdict(result)
    return {name: values[name] for name in type(result).__slots__} | values


TOUCHING_GAP_MM = 0.01
"""Up to this distance from the object a point of the face is labelled and rendered as touching [mm]: assumed."""


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
    """Distance up to which they touch, see `magicsim.deform.contact.touching`, shape (points,) [mm]."""
    relaxation: RelaxationState | None
    """What a rate-dependent body remembers; None in the long term."""
    linearisation: Linearisation | None
    """Where the body's stiffness was taken last: what saves the next step of the path a factorisation."""
    pose: Pose | None
    """The object's pose; None when it cannot touch."""
    force_n: Array
    """Force of the object on the sensor, shape (3,) [N]."""
    torque_nmm: Array
    """Its torque about the origin, shape (3,) [N mm]."""
    contact_area_mm2: float
    """Deformed area of the points that touch [mm2]."""
    table: TableMemory | None = None
    """What friction below a block on a table remembers; None at rest and where the base is bonded."""

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
        """What a notebook shows: its figures."""
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
            relaxation=None,
            linearisation=None,
            pose=None,
            force_n=np.zeros(3),
            torque_nmm=np.zeros(3),
            contact_area_mm2=0.0,
            max_penetration_mm=0.0,
            min_jacobian=1.0,
            force_balance=0.0,
            iterations=0,
            cutbacks=0,
            restarts=0,
            shifted=0,
            rungs=(),
            unknowns=3 * lattice.free_nodes,
            converged=True,
        )
