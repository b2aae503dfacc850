"""Where the contact face can be touched, and node planes that are fine there and coarse far away.

An object deforms the block near the contact; a few heights away the lattice only has to be stiff enough. Planes keep
their spacing inside the zone and its margin, and spread geometrically beyond it. They stay on the planes of the uniform
lattice, so a coarse cell is a whole number of fine ones and the faces between skin and core are kept. By default
the force of a fingertip-sized object changes by at most `magicsim.geometry.design.FAR_FIELD_BOUND`.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.edges import Edges, pressed_edges
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import node_spacing_mm
from magicsim.geometry.indenter import Indenter

SAMPLE_MM = 0.1
"""Spacing of the points at which the undeformed face is tested for contact [mm]."""
ROUNDING_MM = 1e-9
"""Slack of every length that is compared: without it rounding would decide where a box of a round size lies, and its
mirror image would get another lattice [mm]."""
BLUNT = 0.5
"""Smallest feature of a blunt object in units of its zone's radius: assumed."""
TINY = 3.5
"""Sides of a zone, in spacings of its points, below which they cannot tell whether the object is blunt: a ball of a
radius of 0.05 mm needs the finest cells to be found at all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """Rectangle of the contact face."""

    low_mm: tuple[float, float]
    """Smallest x and y [mm]."""
    high_mm: tuple[float, float]
    """Largest x and y [mm]."""
    is_blunt: bool = False
    """Whether what touches it has no feature much smaller than it."""
    feature_mm: float = math.inf
    """Smallest feature of what touches it [mm]."""
    edges: Edges | None = None
    """Edges of what touches it; None where it has none."""

    @property
    def radius_mm(self) -> float:
        """Half of its shorter side [mm]."""
        return min(high - low for low, high in zip(self.low_mm, self.high_mm, strict=True)) / 2

    def grown(self, margin_mm: float) -> Self:
        """The zone with a margin on every side [mm]."""
        low_x, low_y = (low - margin_mm for low in self.low_mm)
        high_x, high_y = (high + margin_mm for high in self.high_mm)
        return replace(self, low_mm=(low_x, low_y), high_mm=(high_x, high_y))


def contact_zone(indenters: Iterable[Indenter], design: ElastomerDesign) -> Zone | None:
    """Bounding rectangle of where an object touches the undeformed face or lies above it; None where nowhere."""
    intervals = [round(size / SAMPLE_MM) for size in design.footprint_mm]
    axes = [
        (np.arange(count + 1) - count / 2) * (size / count)
        for count, size in zip(intervals, design.footprint_mm, strict=True)
    ]
    x, y = (axis.ravel() for axis in np.meshgrid(*axes))
    face = np.stack([x, y, design.rise_mm(np.stack([x, y], -1))], 1)
    touched, feature, indenters = np.zeros(len(face), bool), np.inf, tuple(indenters)
    for indenter in indenters:
        feature = min(feature, indenter.shape.feature_mm)
        low, high = (side[:2] for side in indenter.box_mm())
        below = ((face[:, :2] > low - SAMPLE_MM) & (face[:, :2] < high + SAMPLE_MM)).all(axis=1)
        for level in indenter.levels_mm():
            near = np.flatnonzero(below & ~touched)
            distance = indenter.distance(face[near] + np.array([0.0, 0.0, level]))[0]
            touched[near[distance < SAMPLE_MM - ROUNDING_MM]] = True
    if not touched.any():
        return None
    low, high = face[touched].min(0), face[touched].max(0)
    zone = Zone(low_mm=(float(low[0]), float(low[1])), high_mm=(float(high[0]), float(high[1])))
    is_tiny = bool((high - low < TINY * SAMPLE_MM).all())
    half_x, half_y = (size / 2 for size in design.footprint_mm)
    edges = pressed_edges(
        indenters, pitch_mm=node_spacing_mm(design), half_face_mm=(half_x, half_y), half_width_mm=zone.radius_mm
    )
    return replace(zone, is_blunt=is_tiny or feature > BLUNT * zone.radius_mm, feature_mm=feature, edges=edges)


def graded_planes(planes_mm: Array, low_mm: float, high_mm: float, growth: float, *, keep_mm: Array) -> Array:
    """A subset of node planes: all of them from `low_mm` to `high_mm`, fewer and fewer away from there.

    Outside neighbouring spacings grow by a ratio, at least 1, which keeps every plane; some planes must stay [mm].
    """
    if growth == 1:
        return planes_mm
    first = max(int(np.searchsorted(planes_mm, low_mm + ROUNDING_MM, side="right")) - 1, 0)
    last = min(int(np.searchsorted(planes_mm, high_mm - ROUNDING_MM, side="left")), len(planes_mm) - 1)
    chosen = np.zeros(len(planes_mm), bool)
    chosen[first : last + 1] = True
    chosen[np.abs(planes_mm[:, None] - keep_mm).argmin(0)] = True
    chosen[[0, -1]] = True
    spacing = float(planes_mm[last] - planes_mm[first]) / max(last - first, 1)
    with np.errstate(over="ignore"):  # far beyond the last plane
        steps = spacing * np.cumsum(growth ** np.arange(1, len(planes_mm)))
    chosen[last + _nearest(planes_mm[last:] - planes_mm[last], steps)] = True
    chosen[first - _nearest(planes_mm[first] - planes_mm[first::-1], steps)] = True
    return planes_mm[chosen]


def _nearest(distances: Array, steps: Array) -> Index:
    """Index of the distance nearest to each step that ends inside; the shorter of two that are as near."""
    inside = steps[steps < distances[-1]]
    return np.asarray(np.argmin(np.round(np.abs(distances[:, None] - inside), 9), axis=0))
