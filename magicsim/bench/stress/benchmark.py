"""Runs the stress grid, in this process or on all cores, and counts what came of it."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from magicsim.bench.deform.compare import machine
from magicsim.bench.stress.cases import POISSON_RATIOS, StressPath, every_path
from magicsim.bench.stress.grid import JUDGED_SHARE, NOT_AVAILABLE, OUTCOMES, VALID, StressRow, run_path
from magicsim.bench.stress.pool import pooled_rows
from magicsim.deform.indentation.press import compile_kernels


def run_stress(
    *, quick: bool = False, paths: Sequence[StressPath] | None = None, parts: Path | None = None
) -> dict[str, Any]:
    """Runs the grid and the single cases.

    Args:
        quick: Only a fifth of the grid, three of the single cases, and the ways of one sphere.
        paths: What to run instead, in this process.
        parts: Folder for the rows of the paths, from which a killed run goes on; by default they are not kept.

    Returns:
        The object that the plot is drawn from: `results`, `summary`, `machine`.
    """
    compile_kernels()
    if paths is not None:
        rows = [row for path in paths for row in run_path(path)]
    else:
        chosen = [path for path in every_path() if not quick or _is_quick(path)]
        with TemporaryDirectory() as temporary:
            rows = pooled_rows(chosen, parts or Path(temporary))
    return {
        "kind": "stress",
        "quick": quick,
        "results": [asdict(row) for row in rows],
        "summary": summarise(rows),
        "machine": machine(),
    }


def summarise(rows: Iterable[StressRow]) -> dict[str, Any]:
    """Counts of outcomes, and the share that is valid up to half of the height."""
    found = list(rows)
    counts = Counter(row.outcome for row in found)
    judged = [row for row in found if row.depth_share <= JUDGED_SHARE and row.outcome != NOT_AVAILABLE]
    valid = sum(row.outcome == VALID for row in judged)
    return {
        "cases": len(found),
        "outcomes": {outcome: counts[outcome] for outcome in OUTCOMES},
        "judged": len(judged),
        "valid_share": valid / len(judged) if judged else None,
        "seconds": sum(row.seconds for row in found),
    }


def _is_quick(path: StressPath) -> bool:
    if path.group == "single":
        return path.label in {"skin 0.1 mm", "height 1.5 mm", "one step of 50 %"}
    if path.group in {"friction", "relaxing"}:
        return path.label.endswith("sphere 4 mm")
    return path.contrast in {1.0, 1e4} and path.poisson_ratio in {POISSON_RATIOS[0], POISSON_RATIOS[2]}
