"""The methods and settings that are compared, and the package's own lattice as one. Another method is one more line."""

import importlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any

from laboratory.deform.problem import (
    NOT_INSTALLED,
    Failure,
    Observation,
    Outcome,
    Solve,
    SphereOnBlock,
    displacement_at,
    repeats_left,
)
from magicsim.arrays import Array
from magicsim.config.models import validate
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.spot import QUARTERS, central_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.plain import SphereObject

GRADED, FELUPE, QUARTER = "graded lattice", "felupe", "quarter"
STEEP = {"growth": 2.0, "margin": 0.0, "fine_depth": 0.5}
"""Lattice options of a grading as steep as the force alone allows."""
Build = Callable[[SphereOnBlock, ElastomerDesign], Lattice]


def uniform(problem: SphereOnBlock, design: ElastomerDesign) -> Lattice:
    """One spacing everywhere."""
    del problem
    return build_lattice(design)


def graded(problem: SphereOnBlock, design: ElastomerDesign) -> Lattice:
    """The design's spacing where the sphere can touch, coarser away from there."""
    deepest = sphere_at(problem, problem.depths_mm[-1])
    return build_lattice(design, zone=contact_zone([deepest], design))


def graded_quarter(problem: SphereOnBlock, design: ElastomerDesign) -> Lattice:
    """A quarter of the block by symmetry, the design's spacing where the sphere can touch."""
    zone = contact_zone([sphere_at(problem, problem.depths_mm[-1])], design)
    if zone is None:
        msg = "the sphere does not reach the block"
        raise ConfigError(msg)
    return central_lattice(design, zone, spacing_mm=design.lattice.spacing_mm or 1.0, is_quarter=True)


def sphere_at(problem: SphereOnBlock, depth_mm: float) -> Indenter:
    """The sphere at a depth from first contact [mm]."""
    return place_object(SphereObject(kind="sphere", radius_mm=problem.radius_mm), gap_mm=-depth_mm)


def steep(problem: SphereOnBlock, design: ElastomerDesign) -> Lattice:
    """The design's spacing below the sphere alone, and twice as coarse from cell to cell away from there."""
    return graded(problem, _steeper(design))


def steep_quarter(problem: SphereOnBlock, design: ElastomerDesign) -> Lattice:
    """A quarter of such a block."""
    return graded_quarter(problem, _steeper(design))


def _steeper(design: ElastomerDesign) -> ElastomerDesign:
    return design.model_copy(update={"lattice": design.lattice.model_copy(update=STEEP)})


def solve_lattice(
    problem: SphereOnBlock, repeats: int, *, spacing_mm: float, tolerance_mm: float, build: Build = uniform
) -> Iterator[Outcome]:
    """Presses in steps, each a warm start from the one before.

    Args:
        problem: What to solve.
        repeats: Runs of each timed step.
        spacing_mm: Node spacing, the finest where it varies [mm].
        tolerance_mm: Largest penetration [mm].
        build: Makes the lattice of a design.
    """
    compile_kernels()
    start = time.perf_counter()
    data = problem.design.model_dump()
    data["lattice"] |= {"spacing_mm": spacing_mm}
    lattice = build(problem, validate(ElastomerDesign, data, source="benchmark"))
    solver, copies = ContactSolver(lattice, tolerance_mm=tolerance_mm), QUARTERS if lattice.is_mirrored else 1
    total = time.perf_counter() - start
    state: Deformation | None = None
    for step in count(1):
        depth = step * problem.step_mm
        if depth > problem.depths_mm[-1] + 1e-9:
            return
        indenter, before = sphere_at(problem, depth), state
        start = time.perf_counter()
        try:
            state = solver.solve(indenter, before)
        except ConvergenceError as error:
            total += time.perf_counter() - start
            if problem.is_compared(step):
                yield Failure(
                    depth_mm=depth, message=str(error), seconds_total=total, unknowns=3 * lattice.free_nodes
                )  # fmt: skip
            continue
        seconds = [time.perf_counter() - start]
        total += seconds[0]
        if problem.is_compared(step):
            for _ in range(repeats_left(seconds[0], repeats)):
                start = time.perf_counter()
                solver.solve(indenter, before)
                seconds.append(time.perf_counter() - start)
            yield Observation(
                depth_mm=depth,
                force_n=copies * float(state.force_n[2]),
                contact_area_mm2=copies * state.contact_area_mm2,
                surface_mm=_surface(lattice, state, problem.sample_points_mm),
                seconds=tuple(seconds),
                seconds_total=total,
                unknowns=state.unknowns,
                iterations=state.iterations,
            )


def _surface(lattice: Lattice, state: Deformation, points_mm: Array) -> Array:
    x, y = lattice.planes_mm[:2]
    return displacement_at(points_mm, x, y, state.displacements_mm[: len(x) * len(y)].reshape(len(y), len(x), 3))


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """A method with its settings."""

    method: str
    """Name of its curve."""
    setting: str
    """Value that varies along the curve."""
    solve: Solve
    quick: bool = False
    """Whether a quick benchmark includes it."""


def solve_optional(problem: SphereOnBlock, repeats: int, *, module: str, solve: str, **settings: Any) -> Iterator[Outcome]:  # noqa: ANN401, E501  # fmt: skip
    """Runs a method whose package may be missing or not load, for lack of a library; such a one fails at every depth.

    Args:
        problem: What to solve.
        repeats: Runs of each timed step.
        module: Where the method is.
        solve: Its function.
        settings: What it takes.
    """
    try:
        method = getattr(importlib.import_module(module), solve)
    except ImportError:
        for depth in problem.depths_mm:
            yield Failure(depth_mm=depth, message=NOT_INSTALLED, seconds_total=0.0)
        return
    yield from method(problem, repeats, **settings)


_felupe = partial(solve_optional, module="laboratory.deform.felupe_method", solve="solve_felupe")
_ngsolve = partial(solve_optional, module="laboratory.deform.ngsolve_reference", solve="solve_ngsolve")


def _lattices(method: str, build: Build, spacings: tuple[float, ...], tolerance_mm: float = 0.002) -> list[Variant]:
    return [
        Variant(
            method=f"{method}, tolerance {tolerance_mm:g} mm",
            setting=f"{spacing:g} mm",
            solve=partial(solve_lattice, spacing_mm=spacing, tolerance_mm=tolerance_mm, build=build),
            quick=spacing == 1.0,
        )
        for spacing in spacings
    ]  # fmt: skip


def _felupes(method: str, sizes: tuple[float, ...], *, quick: float | None = None, **settings: Any) -> list[Variant]:  # noqa: ANN401  # fmt: skip
    return [
        Variant(
            method=f"{FELUPE}, {method}", setting=f"{size:g} mm", quick=size == quick,
            solve=partial(_felupe, element_mm=size, **settings),
        )
        for size in sizes
    ]  # fmt: skip


VARIANTS: tuple[Variant, ...] = (
    *_lattices("lattice", uniform, (1.0, 0.75, 0.5)),
    *_lattices(GRADED, graded, (1.5, 1.25, 1.0, 0.75, 0.5, 0.375)),
    *_lattices(GRADED, graded, (1.0, 0.5), tolerance_mm=0.01),
    *_lattices(f"{GRADED}, {QUARTER}", graded_quarter, (1.5, 1.0, 0.75, 0.5, 0.375)),
    *_lattices(f"{GRADED}, steep", steep, (1.25, 1.0, 0.75, 0.6, 0.5, 0.375)),
    *_lattices(f"{GRADED}, steep, {QUARTER}", steep_quarter, (1.25, 1.0, 0.75, 0.6, 0.5, 0.375)),
    *_felupes("whole block", (1.0, 0.75), whole=True),
    *_felupes("graded whole block", (1.0, 0.75, 0.5), growth=1.5, whole=True),
    *_felupes(QUARTER, (1.0, 0.75)),
    *_felupes(f"graded {QUARTER}", (1.0, 0.75, 0.5, 0.375), quick=1.0, growth=1.5),
    *(
        Variant(
            method=f"NGSolve, {QUARTER}, degree 2", setting=f"{count} elements",
            solve=partial(_ngsolve, elements=count, order=2),
        )
        for count in (4, 6)
    ),
)  # fmt: skip
"""Every curve of the benchmark, coarse to fine."""
