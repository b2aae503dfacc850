"""An object of your own: a capsule that lies along y, exact and without a mesh file.

python docs/examples/own_object.py         # force of capsules of three lengths, half a minute
"""

from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np
import numpy.typing as npt

from magicsim import load_design, press
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.rigid_object import ObjectBase, Size
from magicsim.geometry.shapes import Shape

Array = npt.NDArray[np.float64]
SEGMENTS = 64


@dataclass(frozen=True, slots=True)
class Capsule:
    """All points within a radius of a straight piece of the y axis."""

    radius_mm: float
    length_mm: float

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return self.radius_mm

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        half = self.length_mm / 2
        offset = points - np.clip(points[:, 1], -half, half)[:, None] * [0.0, 1.0, 0.0]
        length = np.linalg.norm(offset, axis=1)
        return length - self.radius_mm, offset / np.maximum(length, 1e-300)[:, None]

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return float(self.radius_mm * np.linalg.norm(direction) + self.length_mm / 2 * abs(direction[1]))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        ball = manifold3d.Manifold.sphere(self.radius_mm, SEGMENTS)
        ends = [ball.translate((0.0, side * self.length_mm / 2, 0.0)) for side in (-1, 1)]
        return from_manifold(manifold3d.Manifold.batch_hull(ends))


class CapsuleObject(ObjectBase):
    """What a user writes: sizes with their units, checked; colour and rotation come with `ObjectBase`."""

    kind: Literal["capsule"] = "capsule"
    radius_mm: Size
    length_mm: Size

    def shape(self) -> Shape:
        """The solid, about its origin."""
        return Capsule(self.radius_mm, self.length_mm)


def force_n(length_mm: float, settings: list[str]) -> float:
    """Normal force of a capsule of radius 2 mm, 0.5 mm deep [N]."""
    capsule = CapsuleObject(radius_mm=2.0, length_mm=length_mm)
    return press(load_design("mini-magictac", settings), capsule, depth_mm=0.5).force_n[2]


if __name__ == "__main__":
    for length in (0.1, 2.0, 6.0):
        print(f"{length:g} mm: {force_n(length, []):.3f} N")
