"""Error against run time: every method on the sphere and the block, against the reference."""

import logging
import os
import platform
from collections.abc import Iterable
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from magicsim.bench.deform.equal_error import equal_errors
from magicsim.bench.deform.methods import VARIANTS, Variant
from magicsim.bench.deform.problem import SphereOnBlock, sphere_on_block
from magicsim.bench.deform.reference import Reference, load_reference
from magicsim.bench.deform.rows import BenchRow, score

LOGGER = logging.getLogger(__name__)
REPEATS = 5
PACKAGES = ("magicsim", "numpy", "scipy", "pypardiso", "felupe", "ngsolve")


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
            LOGGER.info("%s, %s, %g mm: %s", row.method, row.setting, row.depth_mm, _figures(row))
            rows.append(row)
    return {
        "kind": "deform",
        "quick": quick,
        "step_mm": problem.step_mm,
        "results": [row.as_dict() for row in rows],
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


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    return {
        "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _figures(row: BenchRow) -> str:
    if row.error_signed is None or row.seconds is None:
        return row.outcome
    return f"force {100 * row.error_signed:+.2f} %, {row.seconds:.3g} s"
