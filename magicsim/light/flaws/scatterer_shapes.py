"""Bubbles and flakes as shapes for Mitsuba's own integrators, which meet them one surface after the other."""

from typing import Any

import numpy as np

from magicsim.geometry.placed_inclusions import PlacedInclusions
from magicsim.light.backend import mi


def scatterer_name(number: int) -> str:
    """Name of a bubble's or a flake's shape."""
    return f"inclusion{number}"


def scatterer_entries(placed: PlacedInclusions, infill_ior: float, reflectance: float, medium: Any) -> dict[str, Any]:
    """Their entries in a scene's dictionary, by name.

    Args:
        placed: Where they are.
        infill_ior: Index of the infill.
        reflectance: Of flakes.
        medium: The infill, or None where it is clear.
    """
    around = {} if medium is None else {"exterior": medium}
    air = {"type": "dielectric", "int_ior": 1.0, "ext_ior": infill_ior}
    ground = {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}}
    flake = {"type": "twosided", "bsdf": ground}
    entries: dict[str, Any] = {}
    for number, to_world in enumerate(transforms(placed)):
        kind = (
            {"type": "sphere", "bsdf": air, **around} if placed.is_bubble[number] else {"type": "disk", "bsdf": flake}
        )
        entries[scatterer_name(number)] = kind | {"to_world": mi.ScalarTransform4f(to_world)}
    return entries


def transforms(placed: PlacedInclusions) -> np.ndarray[Any, np.dtype[np.float64]]:
    """From a unit sphere, or a unit disk across z, to each one's place, shape (inclusions, 4, 4).

    Args:
        placed: Where they are.
    """
    axis = np.eye(3)[np.abs(placed.normals).argmin(1)]
    across = np.cross(placed.normals, axis)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = np.stack([across, np.cross(placed.normals, across), placed.normals], 2)
    turned[placed.is_bubble] = np.eye(3)
    found = np.zeros((len(turned), 4, 4))
    found[:, :3, :3] = turned * placed.radii_mm[:, None, None]
    found[:, :3, 3] = placed.centres_mm
    found[:, 3, 3] = 1
    return found
