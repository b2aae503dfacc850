"""The methods and settings that are compared. Another method is one more line."""

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from magicsim.bench.lattice_method import graded, solve_lattice, uniform
from magicsim.bench.problem import Failure, Outcome, Solve, SphereOnBlock
from magicsim.bench.rows import NOT_INSTALLED


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """A method with its settings."""

    method: str
    """Name of its curve."""
    setting: str
    """What varies along the curve."""
    solve: Solve
    quick: bool = False
    """Whether a quick benchmark includes it."""


def solve_optional(problem: SphereOnBlock, repeats: int, *, module: str, solve: str, **settings: Any) -> Iterator[Outcome]:  # noqa: ANN401, E501  # fmt: skip
    """Runs a method whose package may be missing; a missing one fails at every depth.

    Args:
        problem: What to solve.
        repeats: Runs of each timed step.
        module: Where the method is.
        solve: Its function.
        settings: What it takes.
    """
    try:
        method = getattr(importlib.import_module(module), solve)
    except ModuleNotFoundError:
        for depth in problem.depths_mm:
            yield Failure(depth_mm=depth, message=NOT_INSTALLED, seconds_total=0.0)
        return
    yield from method(problem, repeats, **settings)


_felupe = partial(solve_optional, module="magicsim.bench.felupe_method", solve="solve_felupe")
_ngsolve = partial(solve_optional, module="magicsim.bench.ngsolve_reference", solve="solve_ngsolve")


def _lattices(method: str, build: Any, spacings: tuple[float, ...]) -> list[Variant]:  # noqa: ANN401
    return [
        Variant(
            method=f"{method}, tolerance {tolerance:g} mm",
            setting=f"{spacing:g} mm",
            solve=partial(solve_lattice, spacing_mm=spacing, tolerance_mm=tolerance, build=build),
            quick=spacing == 1.0,
        )
        for tolerance in (0.002, 0.01)
        for spacing in spacings
    ]  # fmt: skip


VARIANTS: tuple[Variant, ...] = (
    *_lattices("lattice", uniform, (1.0, 0.75, 0.5)),
    *_lattices("graded lattice", graded, (1.0, 0.75, 0.5, 0.375)),
    *(
        Variant(
            method="felupe, whole block", setting=f"{size:g} mm",
            solve=partial(_felupe, element_mm=size, whole=True),
        )
        for size in (1.0, 0.75, 0.5)
    ),
    *(
        Variant(method="felupe, quarter", setting=f"{size:g} mm", solve=partial(_felupe, element_mm=size))
        for size in (1.0, 0.75, 0.5)
    ),
    *(
        Variant(
            method="felupe, graded whole block", setting=f"{size:g} mm",
            solve=partial(_felupe, element_mm=size, growth=1.5, whole=True),
        )
        for size in (1.0, 0.75, 0.5)
    ),
    *(
        Variant(
            method="felupe, graded quarter", setting=f"{size:g} mm",
            solve=partial(_felupe, element_mm=size, growth=1.5), quick=size == 1.0,
        )
        for size in (1.0, 0.75, 0.5)
    ),
    *(
        Variant(
            method="NGSolve, quarter, degree 2", setting=f"{count} elements",
            solve=partial(_ngsolve, elements=count, order=2),
        )
        for count in (4, 6, 8)
    ),
)  # fmt: skip
"""Every curve of the benchmark, coarse to fine."""
