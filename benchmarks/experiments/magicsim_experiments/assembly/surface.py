"""Elements of a plug's surface that may meet the base: the pin, its rim and end, and the handle's shoulder."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.objects.plain import PlugObject

AROUND, ACROSS, ALONG, RIM = 32, 8, 24, 4
"""Elements around the axis, from the axis outwards on a flat end, along the pin, and across its rounded rim."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elements:
    """Points on the plug's surface in its own frame."""

    points_mm: Array
    """Shape (elements, 3) [mm]."""
    normals: Array
    """Outward, shape (elements, 3)."""
    area_mm2: Array
    """Shape (elements,) [mm2]."""


def plug_elements(plug: PlugObject) -> Elements:
    """The elements of a plug.

    Args:
        plug: Its sizes; the handle is centred on the origin, the pin points along +y.
    """
    solid = plug.solid()
    radius, rim = plug.pin_radius_mm, solid.pin.edge_radius_mm
    shoulder, tip = plug.length_mm / 2, plug.length_mm / 2 + plug.pin_length_mm
    rings: list[tuple[float, float, float, float, float]] = []  # radial, axial, normal along both, width
    rings += [(r, tip, 0.0, 1.0, w) for r, w in _steps(0.0, radius - rim, ACROSS)]
    for angle, width in _steps(0.0, np.pi / 2, RIM):
        across, along = float(np.cos(angle)), float(np.sin(angle))
        rings.append((radius - rim + rim * across, tip - rim + rim * along, across, along, rim * width))
    rings += [(radius, y, 1.0, 0.0, w) for y, w in _steps(shoulder, tip - rim, ALONG)]
    rings += [(r, shoulder, 0.0, 1.0, w) for r, w in _steps(radius, plug.radius_mm - plug.edge_radius_mm, ACROSS)]
    angles = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    cosine, sine = np.cos(angles), np.sin(angles)
    points, normals, areas = [], [], []
    for radial, axial, across, along, width in rings:
        points.append(np.stack([radial * cosine, np.full(AROUND, axial), radial * sine], 1))
        normals.append(np.stack([across * cosine, np.full(AROUND, along), across * sine], 1))
        areas.append(np.full(AROUND, 2 * np.pi * radial * width / AROUND))
    return Elements(points_mm=np.concatenate(points), normals=np.concatenate(normals), area_mm2=np.concatenate(areas))


def _steps(low: float, high: float, count: int) -> list[tuple[float, float]]:
    """Middles and widths of equal steps."""
    width = (high - low) / count
    return [(low + (step + 0.5) * width, width) for step in range(count)]
