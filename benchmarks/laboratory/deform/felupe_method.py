"""felupe (the extra `reference`) as a method of the benchmark, used as one would who knows it well.

Of a quarter of the block by symmetry or of the whole block: trilinear hexahedra with the mean dilatation condensed out
(`SolidBodyNearlyIncompressible`, which is the benchmark's law exactly), Newton with its line search against folded
elements, PARDISO where it is installed, and steps that are halved where Newton fails.
"""

import importlib.util
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import felupe
import numpy as np
import scipy.sparse as sp

from laboratory.deform.problem import Failure, Observation, Outcome, SphereOnBlock, displacement_at, repeats_left
from magicsim.arrays import Array


class SphereContact:
    """Follows felupe's protocol of an item: `assemble.vector`, `assemble.matrix`, `results`."""

    def __init__(self, field: Any, face: Any, *, radius_mm: float, penalty: float) -> None:  # noqa: ANN401
        """Prepares the face.

        Args:
            field: Container with the displacement as its first field.
            face: Boundary region of the hexahedra.
            radius_mm: Of the sphere, whose centre is on the z axis.
            penalty: Traction per penetration [N/mm3].
        """
        self.field = field
        self.radius_mm, self.penalty = radius_mm, penalty
        self.depth_mm = 0.0
        self.results = felupe.mechanics.Results()
        self.assemble = felupe.mechanics.Assemble(vector=self._vector, matrix=self._matrix)
        self._cells = face.mesh.cells
        self._shape = face.h.reshape(*face.h.shape[:2])
        self._area = face.dV.T
        self._rest = field.region.mesh.points
        self._dofs = (3 * self._cells[:, :, None] + np.arange(3)).reshape(len(self._cells), -1)

    @property
    def force_n(self) -> Array:
        """Force of the sphere on the meshed part, shape (3,) [N]."""
        gap, normal, _ = self._gaps()
        pressure = -self.penalty * np.minimum(gap, 0) * self._area
        return np.asarray(np.einsum("cq,cqi->i", pressure, normal))

    @property
    def contact_area_mm2(self) -> float:
        """Deformed area of the quadrature points inside the sphere, a facet's nodes in x and y order assumed."""
        gap = self._gaps()[0]
        return float((self._deformed_area() * (gap < 0)).sum())

    def _gaps(self) -> tuple[Array, Array, Array]:
        """Gap, normal and distance to the centre at the quadrature points, shape (facets, points[, 3])."""
        positions = self._rest + self.field[0].values
        points = np.einsum("cai,aq->cqi", positions[self._cells], self._shape)
        offset = points - [0.0, 0.0, self.depth_mm - self.radius_mm]
        length = np.linalg.norm(offset, axis=2)
        return length - self.radius_mm, offset / length[..., None], length

    def _deformed_area(self) -> Array:
        """Area of each point, the facet's own deformed area shared in proportion, shape (facets, points) [mm2]."""
        on_face = np.flatnonzero(self._shape.any(1))
        corners = (self._rest + self.field[0].values)[self._cells[:, on_face]]
        rest = self._rest[self._cells[:, on_face]]
        return np.asarray(self._area * (_quad_area(corners) / _quad_area(rest))[:, None])

    def _vector(self, field: Any = None, parallel: bool = False) -> Any:  # noqa: ANN401
        del parallel
        self.field = field or self.field
        gap, normal, _ = self._gaps()
        pressure = -self.penalty * np.minimum(gap, 0) * self._area
        force = np.einsum("cq,cqi,aq->cai", pressure, normal, self._shape).reshape(len(self._cells), -1)
        vector = np.bincount(self._dofs.ravel(), -force.ravel(), minlength=self._rest.size)
        self.results.force = sp.csr_matrix(vector[:, None])
        return self.results.force

    def _matrix(self, field: Any = None, parallel: bool = False) -> Any:  # noqa: ANN401
        del parallel
        self.field = field or self.field
        gap, normal, length = self._gaps()
        hit = np.flatnonzero((gap < 0).any(1))
        gap, normal, length = gap[hit], normal[hit], length[hit]
        along = normal[..., :, None] * normal[..., None, :]
        local = along + (gap / length)[..., None, None] * (np.eye(3) - along)
        local *= (self.penalty * (gap < 0) * self._area[hit])[..., None, None]
        size = self._dofs.shape[1]
        blocks = np.einsum("cqij,aq,bq->caibj", local, self._shape, self._shape, optimize=True)
        blocks = blocks.reshape(len(hit), size, size)
        rows = np.broadcast_to(self._dofs[hit][:, :, None], blocks.shape)
        columns = np.broadcast_to(self._dofs[hit][:, None, :], blocks.shape)
        entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
        self.results.stiffness = sp.csr_matrix(entries, shape=(self._rest.size,) * 2)
        return self.results.stiffness


def _quad_area(corners: Array) -> Array:
    """Area of quadrilaterals from the cross product of their diagonals, shape (count,)."""
    diagonals = np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
    return np.asarray(diagonals / 2)


PENALTY_RATIO = 100.0
"""Contact penalty in units of Young's modulus over the element size."""
SHORTEST = 1 / 16
"""Shortest step in units of the problem's."""


@dataclass(slots=True, kw_only=True)
class Press:
    """The discretised quarter block and where it stands."""

    field: Any
    solid: Any
    contact: SphereContact
    fixed: Any
    """Degrees of freedom that do not move."""
    free: Any
    depth_mm: float = 0.0


def solve_felupe(
    problem: SphereOnBlock, repeats: int, *, element_mm: float, growth: float = 1.0, whole: bool = False
) -> Iterator[Outcome]:
    """Presses in steps, each a warm start from the one before.

    Args:
        problem: What to solve.
        repeats: Runs of each timed step.
        element_mm: Size of the hexahedra, under the sphere where it varies [mm].
        growth: Ratio of neighbouring elements outside of the contact; 1 keeps them even.
        whole: Whether to mesh the whole block, as poses without symmetry need it.
    """
    start = time.perf_counter()
    axes = _axes(problem, element_mm, growth, whole=whole)
    copies = 1 if whole else 4
    press = _press(problem, axes, element_mm)
    solver, total = _sparse_solver(), time.perf_counter() - start
    unknowns = len(press.free)
    for step in range(1, problem.steps + 1):
        depth, is_compared = step * problem.step_mm, problem.is_compared(step)
        saved = _save(press)
        start = time.perf_counter()
        iterations = _advance(press, depth, problem.step_mm, solver)
        seconds = [time.perf_counter() - start]
        total += seconds[0]
        if iterations is None:
            _restore(press, saved)
            for missed in (one for one in problem.depths_mm if one >= depth - 1e-9):
                message = f"felupe did not converge between {saved[2]:g} and {depth:g} mm"
                yield Failure(depth_mm=missed, message=message, seconds_total=total, unknowns=unknowns)
            return
        if not is_compared:
            continue
        for _ in range(repeats_left(seconds[0], repeats)):
            _restore(press, saved)
            start = time.perf_counter()
            _advance(press, depth, problem.step_mm, solver)
            seconds.append(time.perf_counter() - start)
        yield Observation(
            depth_mm=depth,
            force_n=copies * float(press.contact.force_n[2]),
            contact_area_mm2=copies * press.contact.contact_area_mm2,
            surface_mm=_surface(press, axes, problem.sample_points_mm),
            seconds=tuple(seconds),
            seconds_total=total,
            unknowns=unknowns,
            iterations=iterations,
        )


def _axes(problem: SphereOnBlock, element_mm: float, growth: float, *, whole: bool) -> tuple[Array, Array, Array]:
    """Element boundaries along x, y and z [mm]."""
    zone = (problem.radius_mm * problem.depths_mm[-1]) ** 0.5 * 1.2
    lengths = (*problem.half_mm, problem.design.height_mm)
    x, y, z = (
        _axis(element_mm, min(length, zone if number < 2 else zone / 2), length, growth)
        for number, length in enumerate(lengths)
    )
    if whole:
        x, y = (np.concatenate([-axis[:0:-1], axis]) for axis in (x, y))
    return x, y, z


def _axis(element_mm: float, zone_mm: float, length_mm: float, growth: float) -> Array:
    if growth == 1:
        return np.linspace(0, length_mm, round(length_mm / element_mm) + 1)
    near = np.linspace(0, zone_mm, int(np.ceil(zone_mm / element_mm)) + 1)
    reached = np.cumsum(near[1] * growth ** np.arange(1, 100))
    last = max(1, int(np.argmin(np.abs(reached - (length_mm - zone_mm)))) + 1)
    return np.concatenate([near, zone_mm + reached[:last] * (length_mm - zone_mm) / reached[last - 1]])


def _press(problem: SphereOnBlock, axes: tuple[Array, Array, Array], element_mm: float) -> Press:
    mesh = felupe.Grid(*axes)
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
    face = felupe.RegionHexahedronBoundary(mesh, mask=np.isclose(mesh.points[:, 2], 0), only_surface=True)
    solid = felupe.SolidBodyNearlyIncompressible(
        felupe.NeoHookeCompressible(mu=problem.shear_modulus_mpa), field, bulk=problem.lame_mpa
    )
    modulus = problem.design.materials.body.youngs_modulus_mpa
    contact = SphereContact(field, face, radius_mm=problem.radius_mm, penalty=PENALTY_RATIO * modulus / element_mm)
    boundaries = {"bonded": felupe.Boundary(field[0], fz=problem.design.height_mm)}
    if axes[0][0] == 0:  # a quarter
        boundaries["plane x"] = felupe.Boundary(field[0], fx=0, skip=(0, 1, 1))
        boundaries["plane y"] = felupe.Boundary(field[0], fy=0, skip=(1, 0, 1))
    fixed, free = felupe.dof.partition(field, boundaries)
    return Press(field=field, solid=solid, contact=contact, fixed=fixed, free=free)


def _advance(press: Press, depth_mm: float, step_mm: float, solver: Callable[..., Any]) -> int | None:
    """Moves the sphere to a depth, halving steps that fail; returns the iterations, None where it failed."""
    stride, iterations = depth_mm - press.depth_mm, 0
    while press.depth_mm < depth_mm - 1e-9:
        saved = _save(press)
        press.contact.depth_mm = min(press.depth_mm + stride, depth_mm)
        try:
            with warnings.catch_warnings(action="ignore"):  # folded trial elements
                result = felupe.newtonraphson(
                    press.field, items=[press.solid, press.contact], dof0=press.fixed, dof1=press.free,
                    ext0=np.zeros(len(press.fixed)), solver=solver, verbose=0,
                    plugins=[felupe.LinesearchPlugin(residual=False)],
                )  # fmt: skip
        except (felupe.NewtonConvergenceError, np.linalg.LinAlgError):
            _restore(press, saved)
            stride /= 2
            if stride < SHORTEST * step_mm:
                return None
            continue
        press.field, press.depth_mm = result.x, press.contact.depth_mm
        iterations += result.iterations
    return iterations


def _save(press: Press) -> tuple[Any, dict[str, Any], float]:
    return press.field, press.solid.checkpoint(), press.depth_mm


def _restore(press: Press, saved: tuple[Any, dict[str, Any], float]) -> None:
    press.field, checkpoint, press.depth_mm = saved
    press.solid.field.link(press.field)
    press.solid.restore(checkpoint)
    press.contact.field, press.contact.depth_mm = press.field, press.depth_mm


def _surface(press: Press, axes: tuple[Array, Array, Array], points_mm: Array) -> Array:
    """Displacement at points of the face, shape (points, 3) [mm]."""
    x, y, _ = axes
    mesh, values = press.field.region.mesh.points, press.field[0].values
    face = np.flatnonzero(np.isclose(mesh[:, 2], 0))
    order = face[np.lexsort((mesh[face, 0], mesh[face, 1]))]
    return displacement_at(points_mm, x, y, values[order].reshape(len(y), len(x), 3))


def _sparse_solver() -> Callable[..., Any]:
    """PARDISO where it is installed, else felupe's default."""
    if importlib.util.find_spec("pypardiso") is None:
        from scipy.sparse.linalg import spsolve

        return spsolve
    import pypardiso

    return pypardiso.spsolve  # type: ignore[no-any-return]
