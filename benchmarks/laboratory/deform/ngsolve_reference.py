"""An independent finite-element solution of the sphere on the block, with NGSolve (the extra `reference`).

It shares no code with the package: a quarter of the block by symmetry, graded hexahedra of degree 2 or 3, the volume
term with an independent discontinuous pressure p that is condensed out, p (J - 1) - p^2 / 2 lambda, and contact by a
penalty at its own quadrature points with the exact condition, the deformed point's distance to the sphere's centre.
A coat with stiffness is a neo-Hookean membrane on the contact face.
Two penalties are extrapolated to a rigid contact. Newton starts from an extrapolation of the last two steps; the
independent pressure is what lets it converge in few iterations.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import ngsolve as ngs
import numpy as np
from ngsolve.meshes import MakeStructured3DMesh

from laboratory.deform.problem import Failure, Observation, Outcome, SphereOnBlock, repeats_left
from magicsim.arrays import Array

ZONE = 1.35
"""Extent of the fine elements across the contact in units of sqrt(radius depth); half of it along z."""
PENALTIES = (150.0, 300.0)
"""Contact stiffness [N/mm3]; the error is inversely proportional to it. The path is
followed with the stiffer one: making a contact softer is easy, stiffer is not."""
SOFT_PENALTY = 5.0
"""Stiffness that the first step, which has nothing to extrapolate from, is begun with [N/mm3]."""
TOLERANCE = 1e-6
"""Square root of the last Newton step's decrement [sqrt(N mm)]; the error after that step is its square."""
MAX_ITERATIONS, MAX_HALVINGS = 18, 12
LONGEST_STEP, SHORTEST_STEP = 0.4, 1 / 16
"""Motion of the sphere between two solves: the first in units of the smallest element, the shortest in units of it."""
CONTACT_ORDER, AREA_ORDER = 4, 20
"""Additional quadrature order of contact forces and of the contact area, whose integrand jumps."""
FACE_SPACING_MM, GEOMETRY_ORDER = 0.02, 2
"""Places between which a curved face is read linearly, and polynomial degree of the elements' own shape."""


class NoConvergenceError(RuntimeError):
    """Newton's method gave up."""


@dataclass(slots=True, kw_only=True)
class Quarter:
    """The discretised quarter block and its state."""

    mesh: Any
    form: Any
    state: Any
    """Displacement and pressure."""
    depth: Any
    penalty: Any
    fine_mm: float
    """Smallest element."""
    overlap: Any
    """Penetration and the sphere's normal along z that follow from a displacement."""

    @property
    def force_n(self) -> float:
        """Force of the sphere on the whole block."""
        inside, upward = self.overlap(self.state.components[0])
        measure = ngs.ds("bottom", bonus_intorder=CONTACT_ORDER)
        return 4 * float(ngs.Integrate(self.penalty * inside * upward * measure, self.mesh))

    @property
    def contact_area_mm2(self) -> float:
        """Deformed area inside the sphere."""
        displacement = self.state.components[0]
        stretched = ngs.Cof(ngs.Id(3) + ngs.Grad(displacement)) * ngs.specialcf.normal(3)
        inside = ngs.IfPos(self.overlap(displacement)[0], ngs.Norm(stretched), 0)
        return 4 * float(ngs.Integrate(inside * ngs.ds("bottom", bonus_intorder=AREA_ORDER), self.mesh))

    def displacement(self, points_mm: Array) -> Array:
        """At points of the undeformed face, shape (points, 3) [mm]."""
        values = [self.state.components[0](self.mesh(*point)) for point in points_mm.tolist()]
        return np.array(values, float)


def solve_ngsolve(problem: SphereOnBlock, repeats: int, *, elements: int, order: int) -> Iterator[Outcome]:
    """Presses in steps, each a warm start from the two before.

    Args:
        problem: What to solve.
        repeats: Runs of each timed step.
        elements: Even number of elements from the axis to the end of the fine zone at the deepest depth.
        order: Polynomial degree of the displacement; the pressure's is one less.
    """
    with ngs.TaskManager():
        start = time.perf_counter()
        quarter = _quarter(problem, elements, order)
        unknowns = 3 * int(quarter.form.space.components[0].ndof // 3)
        total = time.perf_counter() - start
        longest = LONGEST_STEP * quarter.fine_mm
        past = Past(before=_copy(quarter.state.vec), now=_copy(quarter.state.vec))
        for step in range(1, problem.steps + 1):
            depth, is_compared = step * problem.step_mm, problem.is_compared(step)
            try:
                reached, rigid, seconds = _step(quarter, past, depth, longest, extrapolate=is_compared)
            except NoConvergenceError as error:
                for missed in (one for one in problem.depths_mm if one >= depth - 1e-9):
                    yield Failure(depth_mm=missed, message=str(error), seconds_total=total, unknowns=unknowns)
                return
            total += seconds
            if is_compared:
                surface = quarter.displacement(problem.sample_points_mm)
                again = (
                    _step(quarter, past, depth, longest, extrapolate=is_compared)[2]
                    for _ in range(repeats_left(seconds, repeats))
                )
                yield Observation(
                    depth_mm=depth, force_n=rigid[0], contact_area_mm2=rigid[1], surface_mm=surface,
                    seconds=(seconds, *again), seconds_total=total, unknowns=unknowns, iterations=int(rigid[2]),
                )  # fmt: skip
            past = reached


@dataclass(frozen=True, slots=True, kw_only=True)
class Past:
    """The last two states with the stiffer penalty."""

    before: Any
    now: Any
    depth_mm: float = 0.0
    """Depth of the last step."""
    stride_mm: float = 0.0
    """From the one before to the last one; 0 at rest."""


def _step(
    quarter: Quarter, past: Past, depth_mm: float, longest_mm: float, *, extrapolate: bool
) -> tuple[Past, tuple[float, float, float], float]:
    """One step, in parts that are halved where Newton fails.

    Args:
        quarter: The block; its state becomes the one of the rigid contact where that is extrapolated.
        past: Where it stands.
        depth_mm: Where the step ends [mm].
        longest_mm: Longest part [mm].
        extrapolate: Whether to extrapolate to a rigid contact.

    Returns:
        Where it stands now; rigid force, area and Newton iterations; seconds.

    Raises:
        NoConvergenceError: The shortest part failed.
    """
    start = time.perf_counter()
    stride, iterations = longest_mm, 0
    while past.depth_mm < depth_mm - 1e-9:
        parts = int(np.ceil((depth_mm - past.depth_mm) / stride - 1e-9))
        try:
            past, spent = _part(quarter, past, past.depth_mm + (depth_mm - past.depth_mm) / parts)
        except NoConvergenceError:
            stride /= 2
            if stride < SHORTEST_STEP * longest_mm:
                raise
            continue
        iterations += spent
    if not extrapolate:
        return past, (0.0, 0.0, float(iterations)), time.perf_counter() - start
    quarter.state.vec.data = past.now
    stiff = np.array([quarter.force_n, quarter.contact_area_mm2])
    quarter.penalty.Set(PENALTIES[0])
    iterations += _newton(quarter)
    soft = np.array([quarter.force_n, quarter.contact_area_mm2])
    rest = PENALTIES[0] / (PENALTIES[1] - PENALTIES[0])
    force, area = (stiff + rest * (stiff - soft)).tolist()
    soft_state = _copy(quarter.state.vec)  # a vector must not stand on both sides of an assignment
    quarter.state.vec.data = (1 + rest) * past.now - rest * soft_state
    return past, (force, area, float(iterations)), time.perf_counter() - start


def _part(quarter: Quarter, past: Past, depth_mm: float) -> tuple[Past, int]:
    """Solves with the softer penalty from an extrapolation; where the block stands then, and Newton iterations."""
    stride = depth_mm - past.depth_mm
    reach = stride / past.stride_mm if past.stride_mm > 0 else 0.0
    quarter.state.vec.data = past.now + reach * (past.now - past.before)
    quarter.depth.Set(depth_mm)
    iterations = 0
    for penalty in (SOFT_PENALTY, PENALTIES[1]) if past.stride_mm == 0 else PENALTIES[1:]:
        quarter.penalty.Set(penalty)
        iterations += _newton(quarter)
    moved = Past(before=past.now, now=_copy(quarter.state.vec), depth_mm=depth_mm, stride_mm=stride)
    return moved, iterations


def _copy(vector: Any) -> Any:  # noqa: ANN401
    copy = vector.CreateVector()
    copy.data = vector
    return copy


def _zones_mm(problem: SphereOnBlock) -> tuple[float, float]:
    """Extent along x and y of the fine elements across the contact, at most to the sides of the block [mm]."""
    reach = (ZONE * (radius * problem.depths_mm[-1]) ** 0.5 for radius in problem.effective_radii_mm)
    x, y = (float(min(each, half)) for each, half in zip(reach, problem.half_mm, strict=True))
    return x, y


def _quarter(problem: SphereOnBlock, elements: int, order: int) -> Quarter:
    mesh = _mesh(problem, elements)
    displacements = ngs.VectorH1(
        mesh, order=order, dirichletx="top|back", dirichlety="top|left", dirichletz="top"
    )  # fmt: skip
    space = displacements * ngs.L2(mesh, order=order - 1)
    depth, penalty = ngs.Parameter(0.0), ngs.Parameter(PENALTIES[0])
    mu, lame, radius = problem.shear_modulus_mpa, problem.lame_mpa, problem.radius_mm

    def overlap(displacement: Any) -> tuple[Any, Any]:  # noqa: ANN401 -- NGSolve's expressions have no useful types
        offset = ngs.CF((ngs.x, ngs.y, ngs.z)) + displacement - ngs.CF((0, 0, depth - radius))
        length = ngs.sqrt(ngs.InnerProduct(offset, offset))
        return ngs.IfPos(radius - length, radius - length, 0), offset[2] / length

    u, p = space.TrialFunction()
    gradient = ngs.Id(3) + ngs.Grad(u)
    jacobian = ngs.Det(gradient)
    solid = mu / 2 * (ngs.InnerProduct(gradient, gradient) - 3) - mu * ngs.log(jacobian)
    solid += p * (jacobian - 1) - p * p / (2 * lame)
    form = ngs.BilinearForm(space, symmetric=True, condense=True)
    form += ngs.Variation(solid * ngs.dx)
    form += ngs.Variation(penalty / 2 * overlap(u)[0] ** 2 * ngs.ds("bottom", bonus_intorder=CONTACT_ORDER))
    coat = problem.design.coat
    if coat is not None and coat.shear_n_per_mm > 0:
        along = ngs.Id(3) + ngs.Grad(u).Trace()  # maps the normal to itself
        normal = ngs.Cof(along) * ngs.specialcf.normal(3)
        sheet = ngs.InnerProduct(along, along) - 1 + 1 / ngs.InnerProduct(normal, normal) - 3
        form += ngs.Variation(coat.shear_n_per_mm / 2 * sheet * ngs.ds("bottom"))
    return Quarter(
        mesh=mesh, form=form, state=ngs.GridFunction(space), depth=depth, penalty=penalty,
        fine_mm=min(_zones_mm(problem)) / elements, overlap=overlap,
    )  # fmt: skip


def _mesh(problem: SphereOnBlock, elements: int) -> Any:  # noqa: ANN401
    """Hexahedra; `bottom` is the contact face, `top` the bonded one, `back` is x = 0 and `left` is y = 0."""
    half_x, half_y = problem.half_mm
    zones, height = _zones_mm(problem), problem.design.height_mm
    deep = min(min(zones) / 2, height)
    planes = [
        graded_axis(elements, zones[0], half_x),
        graded_axis(elements, zones[1], half_y),
        graded_axis(elements // 2, deep, height),
    ]

    def place(*unit: float) -> tuple[float, ...]:
        return tuple(
            float(np.interp(value * (len(axis) - 1), np.arange(len(axis)), axis))
            for value, axis in zip(unit, planes, strict=True)
        )

    nx, ny, nz = (len(axis) - 1 for axis in planes)
    mesh = MakeStructured3DMesh(hexes=True, nx=nx, ny=ny, nz=nz, mapping=place)
    if problem.design.face is not None:
        mesh.SetDeformation(_lift(problem, mesh))
    return mesh


def _lift(problem: SphereOnBlock, mesh: Any) -> Any:  # noqa: ANN401
    """Displacement from the box to the block with its curved face, in which flat facets would lie too deep."""
    (half_x, half_y), height = problem.half_mm, problem.design.height_mm
    x, y = (np.linspace(0, half, round(half / FACE_SPACING_MM) + 1) for half in (half_x, half_y))
    rise = problem.design.rise_mm(np.stack(np.meshgrid(x, y), -1))
    face = ngs.VoxelCoefficient((0, 0, 0), (half_x, half_y, height), np.stack([rise, rise]), linear=True)
    lift = ngs.GridFunction(ngs.VectorH1(mesh, order=GEOMETRY_ORDER))
    lift.Set(ngs.CF((0, 0, face * (1 - ngs.z / height))))
    return lift


def graded_axis(count: int, zone_mm: float, length_mm: float, *, growth: float = 1.5) -> Array:
    """Boundaries of elements from 0 to a length: `count` even ones in the zone, growing beyond it [mm]."""
    near = np.linspace(0, zone_mm, count + 1)
    if zone_mm >= length_mm:
        return near * (length_mm / zone_mm)
    widths = near[1] * growth ** np.arange(1, 100)
    reached = np.cumsum(widths)
    last = max(1, int(np.argmin(np.abs(reached - (length_mm - zone_mm)))) + 1)
    far = zone_mm + reached[:last] * (length_mm - zone_mm) / reached[last - 1]
    return np.concatenate([near, far])


def _newton(quarter: Quarter) -> int:
    """Full steps, halved only where an element folds; returns the iterations.

    Raises:
        NoConvergenceError: Too many iterations.
    """
    form, state = quarter.form, quarter.state.vec
    space = form.space
    residual, direction, trial = (state.CreateVector() for _ in range(3))
    condensed = state.CreateVector()
    form.Apply(state, residual)
    for iteration in range(1, MAX_ITERATIONS + 1):
        form.AssembleLinearization(state)
        condensed.data = residual
        condensed.data += form.harmonic_extension_trans * residual
        inverse = form.mat.Inverse(space.FreeDofs(True), inverse="sparsecholesky")
        direction.data = inverse * condensed
        direction.data += form.harmonic_extension * direction
        direction.data += form.inner_solve * condensed
        decrement = abs(ngs.InnerProduct(direction, residual))
        scale = 1.0
        for _ in range(MAX_HALVINGS):
            trial.data = state - scale * direction
            if np.isfinite(form.Energy(trial)):  # the logarithm of a folded element is not a number
                break
            scale /= 2
        state.data = trial
        form.Apply(state, residual)
        if decrement**0.5 < TOLERANCE:
            return iteration
    msg = f"no convergence in {MAX_ITERATIONS} iterations at {quarter.depth.Get():g} mm: decrement {decrement:.2g}"
    raise NoConvergenceError(msg)
