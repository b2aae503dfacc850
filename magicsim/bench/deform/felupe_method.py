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

from magicsim.arrays import Array
from magicsim.bench.deform.felupe_contact import SphereContact
from magicsim.bench.deform.problem import Failure, Observation, Outcome, SphereOnBlock, repeats_left
from magicsim.bench.deform.surface import displacement_at

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
        _axis(element_mm, min(length, zone if number < 2 else zone / 2), length, growth)  # noqa: PLR2004
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
