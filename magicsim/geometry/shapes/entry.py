"""Contact by the side of entry: a point deep inside a solid leaves it where the approaching solid took it up.

The nearest surface of a slender solid is the wrong way out: a point 0.3 mm below a punch's face and 0.1 mm from its
shaft would be pushed sideways, and on the axis of a cone the nearest side flips with every iteration. Between two load
steps the solid moves up by a fraction of its smallest feature, so a point that is inside by more than a thin shell has
entered through the surface above it. For such a point

    gap = -t (n . u),   normal = n,

with u the approach direction, t > 0 the distance along u to the surface and n the outward normal there. For a plane
this is the exact distance, for any smooth surface it is exact to first order in t, and n varies as smoothly as the
surface above: there is no medial axis to flip across. The skin wraps around the shaft in deep presses, so points inside
the shell keep their nearest feature, and so do points further below the surface than a few load steps, which no step
can have carried there. Both limits are blended smoothly: the gap is continuous, and so is the normal down to the reach.

Motion across the approach direction must be stepped by less than the shell where the skin lies against a shaft: a point
further inside than that, near the upper end, is lifted instead of being pushed aside.
"""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.shapes.solids import Shape

RISE_TOLERANCE_MM = 1e-9
"""Accuracy of the rise to the surface above [mm]."""
CLOSE_MM = 0.01
"""Distance to the surface below which steps of the rise are Newton's instead of safe [mm]."""
MIN_SLOPE = 0.05
"""Surfaces more nearly parallel to the approach direction than this sine are approached by safe steps alone."""
MAX_STEPS = 100


@dataclass(frozen=True, slots=True)
class EntrySide:
    """A solid whose deep interior points leave it against the approach direction; nothing else is changed."""

    solid: Shape
    up: tuple[float, float, float]
    """Unit vector in the solid's frame along which it approaches."""
    shell_mm: float
    """Depth up to which the nearest feature is kept [mm]; from twice that on, the side of entry holds."""
    reach_mm: float
    """Longest rise to the surface above at which the rule holds in full [mm]; it has faded out at twice that."""

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return self.solid.feature_mm

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`; inside by more than the shell, gap and normal of the side of entry."""
        distance, normal = self.solid.distance(points)
        deep = np.flatnonzero(distance < -self.shell_mm)
        if len(deep) == 0:
            return distance, normal
        rise, above = self.rise_to_surface(points[deep])
        slope = above @ np.array(self.up)
        weight = _smooth(-distance[deep] / self.shell_mm - 1) * (1 - _smooth(rise / self.reach_mm - 1)) * (slope > 0)
        distance[deep] = (1 - weight) * distance[deep] - weight * rise * slope
        blended = (1 - weight)[:, None] * normal[deep] + weight[:, None] * above
        length = np.linalg.norm(blended, axis=1)
        opposed = length < 1e-6  # noqa: PLR2004
        blended[opposed], length[opposed] = above[opposed], 1.0
        normal[deep] = blended / length[:, None]
        return distance, normal

    def rise_to_surface(self, points: Array) -> tuple[Array, Array]:
        """Distance along `up` to the surface, shape (count,) [mm], and the normal there, for points inside.

        Steps of the distance to the nearest surface never leave the solid (Hart 1996); close to the surface they are
        Newton's. Rises longer than the rule's limit are not followed to their end.
        """
        up = np.array(self.up)
        limit = 2 * self.reach_mm
        rise, above = np.zeros(len(points)), np.zeros_like(points)
        active = np.arange(len(points))
        for _ in range(MAX_STEPS):
            distance, above[active] = self.solid.distance(points[active] + rise[active, None] * up)
            slope = above[active] @ up
            newton = (np.abs(distance) < CLOSE_MM) & (slope > MIN_SLOPE)
            rise[active] -= np.where(newton, distance / np.where(newton, slope, 1), distance)
            active = active[(np.abs(distance) > RISE_TOLERANCE_MM) & (rise[active] <= limit)]
            if len(active) == 0:
                break
        rise[active] = 2 * limit
        return rise, above

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return self.solid.support_mm(direction)

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        return self.solid.mesh()


def _smooth(value: Array) -> Array:
    """A cubic step from 0 at 0 to 1 at 1."""
    t = np.clip(value, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
