"""The reference solution: the sphere on the block, solved much tighter than any method it judges.

`python benchmarks/deform.py --recompute` writes its file with an independent finite-element code (the extra
`reference`; about half an hour on two idle cores); comparing needs the file alone.

The reference is the finest of three meshes; its error is taken as its largest difference from the two coarser ones.
Each depth has its own meshes, fine where the edge of its contact lies: the error of a force oscillates as that edge
crosses coarse elements.
"""

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from laboratory.deform.problem import Observation, Outcome, SphereOnBlock, sphere_on_block
from magicsim.arrays import Array
from magicsim.config.documents import read_json
from magicsim.errors import ConfigError, ConvergenceError, PresetError
from magicsim.folder import result_file

LOGGER = logging.getLogger(__name__)
COMMAND = "python benchmarks/deform.py --recompute"
FILE = Path(__file__).with_name("reference_sphere_block.json")
DECIMALS = 6
"""Digits kept of a displacement in millimetres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceDepth:
    """The reference at one depth, each value with an estimate of its own error."""

    depth_mm: float
    force_n: float
    """Extrapolated to a rigid contact."""
    force_error_n: float
    contact_area_mm2: float
    """Deformed area inside the sphere, extrapolated likewise."""
    contact_area_error_mm2: float
    surface_mm: Array
    """Displacement of the problem's sample points, shape (points, 3) [mm]."""
    surface_error_mm: float
    """Root mean square over the sample points."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """All depths, and how they were computed."""

    depths: tuple[ReferenceDepth, ...]
    method: str
    """One sentence."""
    command: str
    """Command that writes the file."""

    def at(self, depth_mm: float) -> ReferenceDepth:
        """The reference at a depth.

        Raises:
            PresetError: The file does not hold that depth.
        """
        for depth in self.depths:
            if np.isclose(depth.depth_mm, depth_mm):
                return depth
        held = ", ".join(f"{depth.depth_mm:g}" for depth in self.depths)
        msg = f"the reference holds no depth of {depth_mm:g} mm; available: {held}"
        raise PresetError(msg)


def load_reference(file: Path = FILE) -> Reference:
    """Reads a reference.

    Args:
        file: The shipped one by default.

    Raises:
        PresetError: No such file.
    """
    if not file.is_file():
        msg = f"reference '{file}' does not exist; write it with --recompute (needs `pip install magicsim[reference]`)"
        raise PresetError(msg)
    data = read_json(file)
    return Reference(
        depths=tuple(
            ReferenceDepth(**(values | {"surface_mm": np.array(values["surface_mm"], float).reshape(-1, 3)}))
            for values in data["depths"]
        ),
        method=data["method"],
        command=data["command"],
    )


def save_reference(reference: Reference, path: Path) -> None:
    """Writes a reference as JSON, displacements rounded to `DECIMALS`."""
    depths = [
        {
            "depth_mm": depth.depth_mm,
            "force_n": depth.force_n,
            "force_error_n": depth.force_error_n,
            "contact_area_mm2": depth.contact_area_mm2,
            "contact_area_error_mm2": depth.contact_area_error_mm2,
            "surface_error_mm": depth.surface_error_mm,
            "surface_mm": np.round(depth.surface_mm.ravel(), DECIMALS).tolist(),
        }
        for depth in reference.depths
    ]
    data = {"method": reference.method, "command": reference.command, "depths": depths}
    with result_file(path) as partial:
        partial.write_text(json.dumps(data) + "\n", encoding="utf-8")


@dataclass(frozen=True, slots=True, kw_only=True)
class Discretisation:
    """One mesh and degree."""

    elements: int
    """Across the fine zone."""
    order: int


FINEST = Discretisation(elements=8, order=2)
OTHERS = (Discretisation(elements=6, order=2), Discretisation(elements=4, order=2))


def recompute_reference(
    path: Path = FILE,
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
        ConfigError: NGSolve is not installed, or a library that it needs is missing.
        ConvergenceError: A discretisation did not reach a depth.
    """
    try:
        from laboratory.deform.ngsolve_reference import solve_ngsolve
    except ImportError as error:
        msg = f"recompute needs NGSolve, `pip install magicsim[reference]`: {error}"
        raise ConfigError(msg) from None

    problem = problem or sphere_on_block()
    best = _solve(solve_ngsolve, problem, finest)
    rivals = [_solve(solve_ngsolve, problem, other) for other in others]
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


def _solve(
    solve: Callable[..., Iterator[Outcome]], problem: SphereOnBlock, choice: Discretisation
) -> list[Observation]:
    observations = []
    outcomes = (
        outcome
        for depth in problem.depths_mm
        for outcome in solve(problem.down_to(depth), 1, elements=choice.elements, order=choice.order)
    )
    for outcome in outcomes:
        if not isinstance(outcome, Observation):
            msg = f"the reference with {choice} failed at {outcome.depth_mm:g} mm: {outcome.message}"
            raise ConvergenceError(msg)
        LOGGER.info(
            "%s: %.2f mm, %.5f N, %.3f mm2, %.0f s",
            choice, outcome.depth_mm, outcome.force_n, outcome.contact_area_mm2, outcome.seconds_total,
        )  # fmt: skip
        observations.append(outcome)
    return observations


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
