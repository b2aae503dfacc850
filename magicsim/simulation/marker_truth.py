"""Ground truth of markers: where they are in the sensor and in the image, displaced and not."""

from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import face_weights
from magicsim.deform.lattice.follow import FollowMap, follow_map
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign


class MarkerTracks:
    """Markers of one sensor as they move with its lattice."""

    def __init__(self, design: ElastomerDesign, lattice: Lattice) -> None:
        """Hangs the markers on the lattice.

        Args:
            design: A block with markers.
            lattice: The lattice that is solved.
        """
        assert design.markers is not None
        places = design.markers.centres_mm(design.footprint_mm)
        rest = np.column_stack([places, np.full(len(places), design.markers.depth_mm)])
        on_face = design.markers.depth_mm == 0
        self._follow = (
            FollowMap(points_mm=rest, weights=face_weights(lattice, places)) if on_face else follow_map(lattice, rest)
        )

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice) -> Self | None:
        """Those of a block, or None where it has none."""
        return cls(design, lattice) if design.markers is not None else None

    @property
    def rest_mm(self) -> Array:
        """Centres of the undisplaced markers, shape (markers, 3) [mm]."""
        return self._follow.points_mm

    def displaced_mm(self, displacements_mm: Array) -> Array:
        """Centres under nodal displacements of shape (nodes, 3), shape (markers, 3) [mm]."""
        return self._follow.displaced(displacements_mm)
