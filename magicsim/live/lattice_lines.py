"""The lattice as line segments: the edges on the block's surface and, where they can be seen through, its layers."""

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.structure import Lattice

Colors = npt.NDArray[np.uint8]
STILL, MOVED = np.array([120.0, 132.0, 150.0]), np.array([205.0, 60.0, 20.0])
"""Colour of a node at rest and of one that has moved by `FULL_MM`, RGB 0..255."""
FULL_MM = 0.5
"""Displacement of the strongest colour [mm]."""


def lattice_edges(lattice: Lattice) -> Index:
    """Pairs of neighbouring nodes, each once.

    Edges along the sensor's axis are left out inside the block, where they would hide the layers.

    Args:
        lattice: As it is solved, its nodes numbered x fastest and z slowest.

    Returns:
        Shape (edges, 2).
    """
    counts = tuple(len(planes) for planes in lattice.planes_mm)
    number = np.arange(len(lattice.nodes_mm)).reshape(counts[::-1])
    along_x = np.stack([number[:, :, :-1], number[:, :, 1:]], -1).reshape(-1, 2)
    along_y = np.stack([number[:, :-1], number[:, 1:]], -1).reshape(-1, 2)
    rim = np.zeros(number.shape[1:], bool)
    rim[[0, -1], :] = rim[:, [0, -1]] = True
    along_z = np.stack([number[:-1, rim], number[1:, rim]], -1).reshape(-1, 2)
    return np.concatenate([along_x, along_y, along_z])


def segment_colors(displacement_mm: Array, edges: Index) -> Colors:
    """Colour of both ends of each edge, from how far its nodes have moved, uint8 of shape (edges, 2, 3).

    Args:
        displacement_mm: Of each node, shape (nodes,) [mm].
        edges: From `lattice_edges`.
    """
    share = np.clip(displacement_mm / FULL_MM, 0, 1)[edges][..., None]
    return np.asarray(STILL + share * (MOVED - STILL), np.uint8)
