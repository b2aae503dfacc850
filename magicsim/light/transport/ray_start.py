"""Where a ray starts that goes on from a surface: off it, or it would meet it again."""

from typing import Any

from magicsim.light.backend import dr, mi

CLEARANCE = 9e-6
"""Distance from the surface, relative to 1 mm and the largest coordinate: 0.15 micrometres at 16 mm; a thirtieth of it
still meets no surface twice. The way before a start counts as free of scattering: ten times as far off, where Mitsuba
starts rays, a white furnace is 1.0 +- 0.1 % too bright at 10 scatterings per mm, and here 0.05 +- 0.1 % (12 seeds)."""


def leave(si: Any, direction: Any) -> Any:
    """The ray that goes on from a hit.

    Args:
        si: The hit.
        direction: Unit vectors in the scene's frame.
    """
    distance = dr.mulsign(CLEARANCE * (1 + dr.max(dr.abs(si.p))), dr.dot(si.n, direction))
    return mi.Ray3f(dr.fma(distance, si.n, si.p), direction)
