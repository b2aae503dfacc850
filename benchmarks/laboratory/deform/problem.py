"""The problem that all methods solve, and the results that each of them returns."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import RectBivariateSpline

from magicsim.arrays import Array
from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import Dome

SAMPLE_SPACING_MM = 0.5
"""Distance between the points at which surface displacements are compared."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereOnBlock:
    """A rigid frictionless sphere pressed into the middle of a block that is bonded at z = height.

    The solid is W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2 at rest volume.
    """

    design: ElastomerDesign
    """The block."""
    radius_mm: float = 4.0
    """Radius of the sphere."""
    depths_mm: tuple[float, ...] = (0.5, 1.0, 2.5)
    """Depths from first contact at which methods are compared; multiples of the step, increasing [mm]."""
    step_mm: float = 0.25
    """Motion of the sphere between two warm starts."""

    @property
    def half_mm(self) -> tuple[float, float]:
        """Half the footprint along x and y [mm]."""
        return self.design.footprint_mm[0] / 2, self.design.footprint_mm[1] / 2

    @property
    def effective_radii_mm(self) -> tuple[float, float]:
        """Radii along x and y of the body that touches a flat face as the sphere touches a dome [mm]."""
        face = self.design.face
        radii = (face.radius_x_mm, face.radius_y_mm) if isinstance(face, Dome) else (None, None)
        x, y = (1 / (1 / self.radius_mm + 1 / (radius or np.inf)) for radius in radii)
        return float(x), float(y)

    @property
    def shear_modulus_mpa(self) -> float:
        """The block's mu [MPa]."""
        return self.design.materials.body.shear_modulus_mpa

    @property
    def lame_mpa(self) -> float:
        """The block's lambda [MPa]."""
        return self.design.materials.body.lame_mpa

    @property
    def steps(self) -> int:
        """Steps to the deepest depth."""
        return round(self.depths_mm[-1] / self.step_mm)

    @property
    def sample_axes_mm(self) -> tuple[Array, Array]:
        """Coordinates x and y of the sample points on one quarter of the contact face, each from 0 to the edge [mm]."""
        x, y = (np.linspace(0, half, round(half / SAMPLE_SPACING_MM) + 1) for half in self.half_mm)
        return x, y

    @property
    def sample_points_mm(self) -> Array:
        """Sample points at rest, x fastest, shape (points, 3) [mm]; none on a curved face, whose meshes are faceted."""
        if self.design.face is not None:
            return np.zeros((0, 3))
        y, x = np.meshgrid(*self.sample_axes_mm[::-1], indexing="ij")
        return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)

    def is_compared(self, step: int) -> bool:
        """Whether the end of a step (1 is the first) is one of the depths."""
        return bool(np.isclose(step * self.step_mm, self.depths_mm).any())

    def down_to(self, *depths_mm: float) -> "SphereOnBlock":
        """This problem with other depths."""
        return replace(self, depths_mm=depths_mm)


def sphere_on_block(*overrides: str) -> SphereOnBlock:
    """The problem on the preset `uniform-block`.

    Args:
        overrides: `dotted.key=value` settings of the design.
    """
    return SphereOnBlock(design=load_preset(ElastomerDesign, "design", "uniform-block", list(overrides)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """Result of a method at one depth."""

    depth_mm: float
    force_n: float
    """Force of the sphere on the whole block."""
    contact_area_mm2: float
    """Deformed area that touches."""
    surface_mm: Array
    """Displacement of the sample points, shape (points, 3) [mm]."""
    seconds: tuple[float, ...]
    """Wall time of each run of the step that ends here, from the same start."""
    seconds_total: float
    """Wall time of everything up to here, repeats left out."""
    unknowns: int
    """Displacement unknowns."""
    iterations: int
    """Newton iterations of the step that ends here."""


SOLVED, NOT_INSTALLED = "solved", "not installed"
"""Outcome of an observation, and of a method whose package is missing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """A depth that a method did not reach."""

    depth_mm: float
    message: str
    seconds_total: float
    """Wall time spent until it gave up."""
    unknowns: int | None = None
    """Displacement unknowns, where it got that far."""


Outcome = Observation | Failure
Solve = Callable[[SphereOnBlock, int], Iterator[Outcome]]
"""A method: yields one outcome a depth, in order; the number is how often to repeat each timed step."""
LONG_STEP_S = 20.0
"""A step that takes longer is not repeated."""


def repeats_left(seconds: float, repeats: int) -> int:
    """How often to run a step again after a first run that took `seconds`."""
    return repeats - 1 if seconds <= LONG_STEP_S else 0


ROUNDING_MM = 1e-9
"""Slack of a plane's place [mm]."""


def displacement_at(points_mm: Array, x_mm: Array, y_mm: Array, values_mm: Array) -> Array:
    """Displacement at points of the undeformed face, from cubic splines through the nodes.

    Args:
        points_mm: Positions at rest, shape (points, 3) [mm].
        x_mm: Node planes along x, increasing [mm]; planes that begin at 0 belong to a quarter of the block, and its
            mirror images make the splines smooth across the planes of symmetry.
        y_mm: The same along y [mm].
        values_mm: Displacements of the nodes, shape (len(y_mm), len(x_mm), 3) [mm].

    Returns:
        Displacements, shape (points, 3) [mm].
    """
    if x_mm[0] > -ROUNDING_MM:
        values_mm = np.concatenate([values_mm[:, :0:-1] * [-1, 1, 1], values_mm], 1)
        values_mm = np.concatenate([values_mm[:0:-1] * [1, -1, 1], values_mm], 0)
        x_mm, y_mm = (np.concatenate([-axis[:0:-1], axis]) for axis in (x_mm, y_mm))
    degree_y, degree_x = min(3, len(y_mm) - 1), min(3, len(x_mm) - 1)
    splines = (RectBivariateSpline(y_mm, x_mm, values_mm[:, :, axis], kx=degree_y, ky=degree_x) for axis in range(3))
    return np.stack([spline.ev(points_mm[:, 1], points_mm[:, 0]) for spline in splines], 1)
