"""What the benchmark reports: one row for each method, setting and depth, failures included."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from magicsim.bench.deform.problem import Observation, Outcome
from magicsim.bench.deform.reference import Reference, ReferenceDepth

SOLVED = "solved"
NOT_INSTALLED = "not installed"


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
    """That difference over the root mean square of the reference's displacement."""
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

    def as_dict(self) -> dict[str, Any]:
        """The keys of the JSON."""
        return asdict(self)


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
