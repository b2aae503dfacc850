"""The methods and settings that are compared. Another method is one more line."""

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from magicsim.bench.deform.lattice_method import (
    Build,
    graded,
    graded_quarter,
    solve_lattice,
    steep,
    steep_quarter,
    uniform,
)
from magicsim.bench.deform.problem import Failure, Outcome, Solve, SphereOnBlock
from magicsim.bench.deform.rows import NOT_INSTALLED

GRADED, FELUPE, QUARTER = "graded lattice", "felupe", "quarter"


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


_felupe = partial(solve_optional, module="magicsim.bench.deform.felupe_method", solve="solve_felupe")
_ngsolve = partial(solve_optional, module="magicsim.bench.deform.ngsolve_reference", solve="solve_ngsolve")


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
