"""Error against run time: every method on the sphere and the block, against the reference; failures stay rows."""

import logging
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from laboratory.benchmark import machine
from laboratory.deform.methods import FELUPE, GRADED, QUARTER, VARIANTS, Variant
from laboratory.deform.problem import SOLVED, Observation, Outcome, SphereOnBlock, sphere_on_block
from laboratory.deform.reference import Reference, ReferenceDepth, load_reference


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchRow:
    """One method at one setting and depth; None where the method did not get there."""

    method: str
    setting: str
    depth_mm: float
    error: float | None
    """Force over the reference's, less one, without its sign."""
    error_signed: float | None
    """Force over the reference's, less one: positive is too stiff."""
    error_displacement_mm: float | None
    """Root mean square over the sample points of the length of the difference."""
    error_displacement: float | None
    """Difference of displacements over the root mean square of the reference's."""
    error_area: float | None
    """Contact area over the reference's, less one, without its sign."""
    force_n: float | None
    contact_area_mm2: float | None
    seconds: float | None
    """Median wall time of the warm step that ends at this depth."""
    runs: int
    """Runs behind the median."""
    seconds_total: float
    """Wall time from the design to this depth."""
    unknowns: int | None
    """Displacement unknowns."""
    iterations: int | None
    """Newton iterations of the warm step."""
    outcome: str
    """`solved`, `not installed` or why it failed."""


def score(method: str, setting: str, outcome: Outcome, reference: Reference) -> BenchRow:
    """The row of one outcome."""
    if isinstance(outcome, Observation):
        return _solved(method, setting, outcome, reference.at(outcome.depth_mm))
    return BenchRow(
        method=method, setting=setting, depth_mm=outcome.depth_mm, error=None, error_signed=None,
        error_displacement_mm=None, error_displacement=None, error_area=None, force_n=None, contact_area_mm2=None,
        seconds=None, runs=0, seconds_total=outcome.seconds_total, unknowns=outcome.unknowns, iterations=None,
        outcome=outcome.message,
    )  # fmt: skip


def _solved(method: str, setting: str, found: Observation, truth: ReferenceDepth) -> BenchRow:
    difference = _rms(found.surface_mm - truth.surface_mm)
    error = found.force_n / truth.force_n - 1
    return BenchRow(
        method=method,
        setting=setting,
        depth_mm=found.depth_mm,
        error=abs(error),
        error_signed=error,
        error_displacement_mm=difference,
        error_displacement=difference / _rms(truth.surface_mm),
        error_area=abs(found.contact_area_mm2 / truth.contact_area_mm2 - 1),
        force_n=found.force_n,
        contact_area_mm2=found.contact_area_mm2,
        seconds=float(np.median(found.seconds)),
        runs=len(found.seconds),
        seconds_total=found.seconds_total,
        unknowns=found.unknowns,
        iterations=found.iterations,
        outcome=SOLVED,
    )


def _rms(vectors: np.typing.NDArray[np.float64]) -> float:
    """Root mean square length, of shape (count, 3)."""
    return float(np.sqrt((vectors**2).sum(1).mean()))


@dataclass(frozen=True, slots=True, kw_only=True)
class EqualError:
    """One result of another method, and the cheapest of the graded lattice that is as accurate."""

    depth_mm: float
    other: str
    """Method and setting."""
    other_error: float
    """Relative error of the force."""
    other_seconds: float
    """Seconds of its warm step."""
    setting: str | None
    """Spacing and tolerance of the lattice; None where none was as accurate."""
    seconds: float | None
    ratio: float | None
    """Seconds of the other over the lattice's."""


def equal_errors(rows: Iterable[BenchRow]) -> list[EqualError]:
    """For every solved result of felupe, the fastest graded lattice whose force is at least as accurate there.

    A quarter by symmetry is compared with a quarter, and a whole block with a whole one.

    An error that happens to vanish at one depth is no accuracy: a lattice counts with its largest error over all depths
    up to that one.
    """
    solved = [row for row in rows if row.outcome == SOLVED]
    lattices = [row for row in solved if row.method.startswith(GRADED)]
    found = []
    for other in (row for row in solved if row.method.startswith(FELUPE)):
        error = _largest_error(solved, other)
        able = [
            row for row in lattices
            if row.depth_mm == other.depth_mm and (QUARTER in row.method) == (QUARTER in other.method)
            and _largest_error(solved, row) <= error
        ]  # fmt: skip
        best = min(able, key=_seconds, default=None)
        found.append(
            EqualError(
                depth_mm=other.depth_mm,
                other=f"{other.method}, {other.setting}",
                other_error=error,
                other_seconds=_seconds(other),
                setting=f"{best.method}, {best.setting}" if best is not None else None,
                seconds=_seconds(best) if best is not None else None,
                ratio=_seconds(other) / _seconds(best) if best is not None else None,
            )
        )
    return found


def _largest_error(rows: Iterable[BenchRow], row: BenchRow) -> float:
    """Largest error of one method and setting at all depths up to a row's."""
    return max(
        each.error
        for each in rows
        if (each.method, each.setting) == (row.method, row.setting)
        and each.depth_mm <= row.depth_mm
        and each.error is not None
    )


def _seconds(row: BenchRow) -> float:
    return row.seconds if row.seconds is not None else float("inf")


LOGGER = logging.getLogger(__name__)
REPEATS = 5


def compare(
    *,
    quick: bool = False,
    variants: Iterable[Variant] = VARIANTS,
    reference: Reference | None = None,
    problem: SphereOnBlock | None = None,
) -> dict[str, Any]:
    """Runs the methods.

    Args:
        quick: Only the quick variants, each step run once, to the first two depths.
        variants: The methods.
        reference: What they are compared with; the shipped one by default.
        problem: What they solve; the sphere on the preset block by default.

    Returns:
        The object that the plots are drawn from: `results`, `reference`, `machine`.
    """
    problem = problem or sphere_on_block()
    if quick:
        problem = problem.down_to(*problem.depths_mm[:2])
    truth = reference or load_reference()
    rows: list[BenchRow] = []
    for variant in variants:
        if quick and not variant.quick:
            continue
        for outcome in variant.solve(problem, 1 if quick else REPEATS):
            row = score(variant.method, variant.setting, outcome, truth)
            LOGGER.info("%s, %s, %g mm: %s", row.method, row.setting, row.depth_mm, _summary(row))
            rows.append(row)
    return {
        "kind": "deform",
        "quick": quick,
        "step_mm": problem.step_mm,
        "results": [asdict(row) for row in rows],
        "equal_error": [asdict(one) for one in equal_errors(rows)],
        "reference": {
            "method": truth.method,
            "depths": [
                {
                    "depth_mm": depth.depth_mm,
                    "force_n": depth.force_n,
                    "force_error": depth.force_error_n / depth.force_n,
                    "contact_area_mm2": depth.contact_area_mm2,
                    "area_error": depth.contact_area_error_mm2 / depth.contact_area_mm2,
                    "displacement_error_mm": depth.surface_error_mm,
                }
                for depth in truth.depths
            ],
        },
        "machine": machine(),
    }


def _summary(row: BenchRow) -> str:
    if row.error_signed is None or row.seconds is None:
        return row.outcome
    return f"force {100 * row.error_signed:+.2f} %, {row.seconds:.3g} s"
