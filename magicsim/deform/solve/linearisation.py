"""The state at which the stiffness of a body was taken."""

from dataclasses import dataclass

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.energy import Elasticity


@dataclass(frozen=True, slots=True, kw_only=True)
class Linearisation:
    """Where a body's stiffness was taken, and the part of the face that it was condensed onto."""

    elasticity: Elasticity
    """Energy of the body; it changes with every step of a path that takes time."""
    positions: Array
    """Positions of the nodes, shape (nodes, 3) [mm]."""
    pressure: Array
    """Volumetric stress of each cell, shape (cells,) [MPa]."""
    volume_gradient: Array
    """Gradient of each cell's volume there, shape (cells, 24) [mm2]."""
    shift: float
    """Multiple of the spring Laplacian that was added."""
    facets: Index
    """Facets of the face, ascending."""
