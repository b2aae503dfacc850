"""The package's own lattice as a method of the benchmark."""

import time
from collections.abc import Callable, Iterator
from itertools import count

from magicsim.arrays import Array
from magicsim.bench.deform.problem import Failure, Observation, Outcome, SphereOnBlock, repeats_left
from magicsim.bench.deform.surface import displacement_at
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
from magicsim.geometry.objects.kinds import SphereObject

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
