"""Whether a state is valid, from its displacements alone and not from what the solver says about itself."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import POINT_SPACING_MM, contact_face
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_POINTS
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.indenter import Indenter

PENETRATION_SLACK = 1.001
"""Penetration that passes, in units of the tolerance: rounding alone."""
PIERCED_SHARE = 0.01
"""What pressures push back, in units of their sum over all contact points, below which nothing presses back."""
MAX_BALANCE = 1e-5
"""Out-of-balance force that passes, in units of the contact force."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What was found again."""

    min_jacobian: float
    """Smallest ratio of volumes at any Gauss point."""
    penetration_mm: float
    """Deepest contact point inside the object."""
    force_balance: float
    """|the state's contact force + reaction at the bonded plane| / |contact force|."""
    interior_residual: float
    """Largest force on a free node off the contact face, over the contact force."""
    normal_share: float
    """What pressures push back over their sum, friction aside, by which a wedge may hold itself against a pull; an
    object that has pierced the face is only squeezed."""

    def faults(self, tolerance_mm: float) -> tuple[str, ...]:
        """What is not valid, empty where all is.

        Args:
            tolerance_mm: Penetration asked for [mm].
        """
        checks = {
            f"min J {self.min_jacobian:.3g}": self.min_jacobian > 0,
            f"penetration {self.penetration_mm:.3g} mm": self.penetration_mm <= PENETRATION_SLACK * tolerance_mm,
            f"force balance {self.force_balance:.2g}": self.force_balance <= MAX_BALANCE,
            f"interior residual {self.interior_residual:.2g}": self.interior_residual <= MAX_BALANCE,
            f"normal share of the pressures {self.normal_share:.2g}": self.normal_share > PIERCED_SHARE,
        }
        return tuple(words for words, passes in checks.items() if not passes)


def verify(
    lattice: Lattice,
    state: Deformation,
    indenter: Indenter,
    *,
    point_spacing_mm: float = POINT_SPACING_MM,
    elasticity: Elasticity | None = None,
) -> Verification:
    """Recomputes Jacobians, penetration and balance.

    Args:
        lattice: The block.
        state: What the solver returned.
        indenter: The object in its pose.
        point_spacing_mm: Of the contact points that the solver was asked for [mm].
        elasticity: Energy of the body at the end of a step that takes time; None is the lattice's own.
    """
    positions = lattice.nodes_mm + state.displacements_mm
    gradient = (elasticity or Elasticity.of(lattice)).evaluate(positions).gradient
    force = max(float(np.linalg.norm(state.force_n)), 1e-300)
    reaction = gradient[lattice.free_nodes :].sum(0)
    inside = gradient[lattice.layer_nodes : lattice.free_nodes]
    touching = bool(np.any(state.force_n))
    face = contact_face(lattice, point_spacing_mm=point_spacing_mm)
    gap, normal = indenter.distance(face.positions(positions))
    pressing = face.area_mm2 * state.contact_pressure_mpa
    return Verification(
        min_jacobian=float(volume_ratios(lattice.nodes_mm[lattice.cells], positions[lattice.cells]).min()),
        penetration_mm=max(0.0, -float(gap.min())),
        force_balance=float(np.linalg.norm(state.force_n + reaction)) / force if touching else 0.0,
        interior_residual=float(np.linalg.norm(inside, axis=1).max(initial=0.0)) / force if touching else 0.0,
        normal_share=float(pressing @ normal[:, 2] / pressing.sum()) if touching and pressing.any() else 0.0,
    )


def volume_ratios(rest_mm: Array, deformed_mm: Array) -> Array:
    """Deformed over rest volume at the 2 x 2 x 2 Gauss points of trilinear cells of any shape.

    Args:
        rest_mm: Corners at rest, x fastest and z slowest, shape (cells, 8, 3) [mm].
        deformed_mm: The same corners deformed, shape (cells, 8, 3) [mm].

    Returns:
        Determinants of the deformation gradient, shape (cells, 8).
    """
    return np.asarray(_mapped_volume(deformed_mm) / _mapped_volume(rest_mm))


def _mapped_volume(corners: Array) -> Array:
    """Determinant of the map from the unit cube, from differences along its edges, shape (cells, 8)."""
    cube = corners.reshape(-1, 2, 2, 2, 3)  # z, y, x
    volumes = np.empty((len(corners), 8))
    for number, (x, y, z) in enumerate(GAUSS_POINTS):
        wx, wy, wz = np.array([1 - x, x]), np.array([1 - y, y]), np.array([1 - z, z])
        along_x = np.einsum("cjki,j,k->ci", cube[:, :, :, 1] - cube[:, :, :, 0], wz, wy)
        along_y = np.einsum("cjki,j,k->ci", cube[:, :, 1] - cube[:, :, 0], wz, wx)
        along_z = np.einsum("cjki,j,k->ci", cube[:, 1] - cube[:, 0], wy, wx)
        volumes[:, number] = np.einsum("ci,ci->c", along_x, np.cross(along_y, along_z))
    return volumes
