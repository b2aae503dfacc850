"""Markers below the contact face: thin disks inside the body that move with it."""

from typing import Any

import numpy as np

from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.markers import DotMarkers
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.world.disks import disks


def marker_disks(design: ElastomerDesign) -> SurfaceMesh | None:
    """Disks of all markers at rest, facing the contact face, or None where there are none below it.

    Args:
        design: The block.
    """
    markers = design.markers
    if not isinstance(markers, DotMarkers) or markers.depth_mm == 0:
        return None
    places = markers.centres_mm(design.footprint_mm)
    centres = np.column_stack([places, np.full(len(places), markers.depth_mm)])
    return disks(centres, np.array([0.0, 0.0, -1.0]), markers.diameter_mm / 2)


def marker_bsdf(design: ElastomerDesign) -> dict[str, Any]:
    """Entry of their material in a scene's dictionary."""
    assert design.markers is not None
    color = design.markers.color if isinstance(design.markers, DotMarkers) else (0.0, 0.0, 0.0)
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(color)}}
    return {"type": "twosided", "bsdf": diffuse}
