"""Writes the reference file: the sphere on the block, solved much tighter than any method it judges.

    python -m magicsim.bench.deform.recompute     # needs the extra `reference`; about half an hour on two idle cores

The reference is the finest of three meshes; its error is taken as its largest difference from the two coarser ones.
Each depth has its own meshes, fine where the edge of its contact lies: the error of a force oscillates as that edge
crosses coarse elements.
"""

import logging
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from magicsim.bench.deform.ngsolve_reference import solve_ngsolve
from magicsim.bench.deform.problem import Observation, SphereOnBlock, sphere_on_block
from magicsim.bench.deform.reference import Reference, ReferenceDepth, reference_path, save_reference
from magicsim.errors import ConvergenceError

LOGGER = logging.getLogger(__name__)
COMMAND = "python -m magicsim.bench.deform.recompute"


@dataclass(frozen=True, slots=True, kw_only=True)
class Discretisation:
    """One mesh and degree."""

    elements: int
    """Across the fine zone."""
    order: int


FINEST = Discretisation(elements=8, order=2)
OTHERS = (Discretisation(elements=6, order=2), Discretisation(elements=4, order=2))


def recompute_reference(
    path: Path,
    *,
    problem: SphereOnBlock | None = None,
    finest: Discretisation = FINEST,
    others: Sequence[Discretisation] = OTHERS,
) -> Reference:
    """Solves all discretisations and writes the file.

    Args:
        path: The file.
        problem: What to solve; the sphere on the preset block by default.
        finest: What becomes the reference.
        others: What it is compared with.

    Raises:
        ConvergenceError: A discretisation did not reach a depth.
    """
    problem = problem or sphere_on_block()
    best = _solve(problem, finest)
    rivals = [_solve(problem, other) for other in others]
    reference = Reference(
        depths=tuple(
            _depth(own, [rival[number] for rival in rivals]) for number, own in enumerate(best)
        ),
        method=(
            f"NGSolve, a quarter of the block, a mesh for each depth with {finest.elements} hexahedra across the zone "
            f"under the sphere, degree {finest.order} with discontinuous pressures ({best[-1].unknowns} displacement "
            "unknowns at the deepest); errors are the largest difference from "
            + " and ".join(f"{other.elements} hexahedra of degree {other.order}" for other in others)
        ),
        command=COMMAND,
    )  # fmt: skip
    save_reference(reference, path)
    return reference


def _solve(problem: SphereOnBlock, choice: Discretisation) -> list[Observation]:
    found = []
    outcomes = (
        outcome
        for depth in problem.depths_mm
        for outcome in solve_ngsolve(problem.down_to(depth), 1, elements=choice.elements, order=choice.order)
    )
    for outcome in outcomes:
        if not isinstance(outcome, Observation):
            msg = f"the reference with {choice} failed at {outcome.depth_mm:g} mm: {outcome.message}"
            raise ConvergenceError(msg)
        LOGGER.info(
            "%s: %.2f mm, %.5f N, %.3f mm2, %.0f s",
            choice, outcome.depth_mm, outcome.force_n, outcome.contact_area_mm2, outcome.seconds_total,
        )  # fmt: skip
        found.append(outcome)
    return found


def _depth(own: Observation, rivals: Sequence[Observation]) -> ReferenceDepth:
    def rms(rival: Observation) -> float:
        return float(np.sqrt(((rival.surface_mm - own.surface_mm) ** 2).sum(1).mean()))

    return ReferenceDepth(
        depth_mm=own.depth_mm,
        force_n=own.force_n,
        force_error_n=max(abs(rival.force_n - own.force_n) for rival in rivals),
        contact_area_mm2=own.contact_area_mm2,
        contact_area_error_mm2=max(abs(rival.contact_area_mm2 - own.contact_area_mm2) for rival in rivals),
        surface_mm=own.surface_mm,
        surface_error_mm=max(rms(rival) for rival in rivals),
    )


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(message)s")
    recompute_reference(reference_path())
