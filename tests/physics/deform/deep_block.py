"""Blocks that stand for a half-space or a layer, what presses them, and what is read off a sequence of spacings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.deform.contact.face import contact_face
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice, box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.solids import Shape, Sphere

Array = npt.NDArray[np.float64]
Counts = tuple[int, int]
"""Cells from the axis to the side, and from the face to the bottom."""
SHEAR_MPA = 1.0
LEVELS: tuple[Counts, ...] = ((6, 4), (9, 6), (12, 8))
"""Spacings in the proportion 6 : 4 : 3; 2028, 6498 and 15000 unknowns."""


def reduced_modulus_mpa(poisson: float) -> float:
    """E* = E / (1 - nu^2) of the blocks [MPa]."""
    return 2 * SHEAR_MPA / (1 - poisson)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeepBlock:
    """A square block of shear modulus 1 MPa, bonded at z = height, fine near the origin."""

    height_mm: float
    half_width_mm: float
    poisson: float
    flat_mm: float = 1.25
    """Half width of the fine part [mm]."""
    flat_depth_mm: float = 0.5
    """Its depth [mm]."""
    spread_per_mm: float = 2.0
    """Growth of the spacing outside in units of the fine one; 0 is a uniform lattice."""

    def lattice(self, counts: Counts) -> Lattice:
        """The block with so many cells."""
        side = spread_planes(self.half_width_mm, counts[0], flat_mm=self.flat_mm, spread_per_mm=self.spread_per_mm)
        down = spread_planes(self.height_mm, counts[1], flat_mm=self.flat_depth_mm, spread_per_mm=self.spread_per_mm)
        across = np.concatenate([-side[:0:-1], side])
        lame = 2 * SHEAR_MPA * self.poisson / (1 - 2 * self.poisson)
        return box_lattice((across, across, down), shear_modulus_mpa=SHEAR_MPA, lame_mpa=lame)

    def solver(
        self, counts: Counts, *, tolerance_mm: float, friction: float = 0.0, max_step_mm: float = 10.0
    ) -> ContactSolver:
        """Contact with the block on three points an edge of a facet, in as few load steps as the object allows."""
        return ContactSolver(
            self.lattice(counts),
            tolerance_mm=tolerance_mm,
            friction=friction,
            max_step_mm=max_step_mm,
            point_spacing_mm=self.half_width_mm,
        )


def spread_planes(far_mm: float, count: int, *, flat_mm: float, spread_per_mm: float) -> Array:
    """Planes from 0 to `far_mm`: a spacing s up to `flat_mm`, and s (1 + spread (x - flat)) beyond.

    They are a smooth map of equal steps: twice the count halves every spacing.
    """
    if spread_per_mm == 0:
        return np.linspace(0, far_mm, count + 1)
    end = flat_mm + np.log1p(spread_per_mm * (far_mm - flat_mm)) / spread_per_mm
    step = np.linspace(0, end, count + 1)
    beyond = np.maximum(step - flat_mm, 0)
    return np.asarray(np.minimum(step, flat_mm) + np.expm1(spread_per_mm * beyond) / spread_per_mm)


def pressed(shape: Shape, depth_mm: float, *, x_mm: float = 0.0, twist_deg: float = 0.0) -> Indenter:
    """A shape on the z axis, its highest point `depth_mm` above the undeformed face."""
    z_mm = depth_mm - shape.support_mm(np.array([0.0, 0.0, 1.0]))
    return Indenter(shape=shape, pose=Pose.from_degrees(np.array([x_mm, 0.0, z_mm]), yaw=twist_deg))


@dataclass(frozen=True, slots=True)
class Cap:
    """A sphere with its highest point as origin: a centre fifty metres away would round gaps to 1e-11 mm."""

    radius_mm: float

    @property
    def feature_mm(self) -> float:
        return self.radius_mm

    def distance(self, points: Array) -> tuple[Array, Array]:
        from_centre = points + np.array([0.0, 0.0, self.radius_mm])
        length = np.linalg.norm(from_centre, axis=1)
        beyond = (points[:, :2] ** 2).sum(1) + points[:, 2] * (2 * self.radius_mm + points[:, 2])
        return beyond / (length + self.radius_mm), from_centre / length[:, None]

    def support_mm(self, direction: Array) -> float:
        return self.radius_mm * float(np.linalg.norm(direction) - direction[2])

    def mesh(self) -> SurfaceMesh:
        mesh = Sphere(self.radius_mm).mesh()
        return replace(mesh, vertices=mesh.vertices - [0.0, 0.0, self.radius_mm])


def ball(radius_mm: float, depth_mm: float, *, x_mm: float = 0.0, twist_deg: float = 0.0) -> Indenter:
    """A sphere of any radius, beyond what an object of a scene may have."""
    return pressed(Sphere(radius_mm), depth_mm, x_mm=x_mm, twist_deg=twist_deg)


def order(levels: Sequence[Counts], errors: Sequence[float]) -> float:
    """Power p of error ~ spacing^p, by least squares of the logarithms."""
    slope = np.polyfit(np.log([across for across, _ in levels]), np.log(np.abs(errors)), 1)[0]
    return -float(slope)


def limit(levels: Sequence[Counts], values: Sequence[float], *, power: float) -> float:
    """Richardson's extrapolation of the last two values to spacing 0."""
    ratio = levels[-1][0] / levels[-2][0]
    return values[-1] + (values[-1] - values[-2]) / (ratio**power - 1)


def contact_radius_mm(state: Deformation, solver: ContactSolver) -> float:
    """Radius a of the Hertz pressure with the same second moment, <r^2> = 2 a^2 / 5.

    Pressures of single points scatter and the outermost ones come and go with the spacing; moments do not.
    """
    return float(np.sqrt(2.5 * mean_square_radius_mm2(state, solver, axis=2)))


def mean_square_radius_mm2(state: Deformation, solver: ContactSolver, *, axis: int) -> float:
    """<r^2> of one component of the traction over the face, r from the origin [mm2]."""
    lattice = solver.lattice
    face = contact_face(lattice, point_spacing_mm=float(lattice.planes_mm[0][-1]))
    weights = face.area_mm2 * state.contact_traction_mpa[:, axis]
    return float(weights @ (state.contact_points_mm[:, :2] ** 2).sum(1) / weights.sum())
