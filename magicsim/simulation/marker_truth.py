"""Ground truth of markers: where they are in the sensor and in the image, displaced and not."""

from pathlib import Path
from typing import Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import Array
from magicsim.camera.projection import project_px
from magicsim.deform.contact.face import face_weights
from magicsim.deform.lattice.follow import FollowMap, follow_map
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

MARKERS = "markers.parquet"
"""Name of the table of undisplaced markers in a folder of results."""


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


def write_markers(path: Path, tracks: MarkerTracks, design: ElastomerDesign, rig: Rig) -> None:
    """Writes the undisplaced markers, one row each, in the order of every frame's lists.

    Args:
        path: Parquet file.
        tracks: Of the sensor.
        design: The block.
        rig: Lens and camera.
    """
    rest, pixels = tracks.rest_mm, project_px(tracks.rest_mm, design, rig.lens, rig.camera)
    columns = {f"{axis}_mm": rest[:, number] for number, axis in enumerate("xyz")}
    columns |= {"column_px": pixels[:, 0], "row_px": pixels[:, 1]}
    pq.write_table(pa.table(columns), path, compression="zstd")
