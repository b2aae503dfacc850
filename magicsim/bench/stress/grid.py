"""Runs the stress grid and records every case: valid, declared as failed, or silently invalid."""

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from magicsim.bench.stress.cases import Stage, StressPath
from magicsim.bench.stress.limit import OutOfProcessorTimeError
from magicsim.bench.stress.validity import Verification, verify
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.relaxation import Relaxation
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError, MagicsimError

TOLERANCE_MM = 0.002
VALID, DECLARED, SILENT = "valid", "declared failure", "silent invalid"
NOT_AVAILABLE, CRASHED, TIMED_OUT = "not available", "crashed", "timed out"
OUTCOMES = (VALID, DECLARED, SILENT, CRASHED, TIMED_OUT, NOT_AVAILABLE)
"""Only the first two are what a solver may do."""
FIGURES = (
    "force_n", "iterations", "cutbacks", "restarts", "rungs", "min_jacobian", "penetration_mm", "force_balance",
    "interior_residual",
)  # fmt: skip
"""What a row holds of a state."""
JUDGED_SHARE = 0.5
"""Depth in units of the height up to which cases count towards the share that is valid."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StressRow:
    """One case; figures are None where there is no state."""

    group: str
    label: str
    contrast: float | None
    poisson_ratio: float | None
    friction: float
    depth_share: float
    depth_mm: float
    shear_mm: float
    twist_deg: float
    outcome: str
    message: str
    """What the solver or the verification said against it."""
    force_n: float | None
    """Along z."""
    iterations: int | None
    cutbacks: int | None
    restarts: int | None
    rungs: tuple[str, ...] | None
    """What the solve took beyond the ordinary way, see `magicsim.deform.solve.ladder`."""
    min_jacobian: float | None
    """Recomputed from the displacements, as are the following."""
    penetration_mm: float | None
    force_balance: float | None
    interior_residual: float | None
    seconds: float


def run_path(path: StressPath) -> Iterator[StressRow]:
    """One row for each stage, whatever happens; a stage starts where the last valid one ended.

    Raises:
        OutOfProcessorTimeError: Whoever runs it has set a limit.
    """
    options: dict[str, Any] = {"friction": path.friction} if path.friction else {}
    if path.max_step_mm is not None:
        options["max_step_mm"] = path.max_step_mm
    try:
        indenters, lattice = path.indenters(), path.lattice()
        spacing = point_spacing_mm(indenters[0].shape)
        branches = path.branches(lattice)
        relaxation = None if branches is None else Relaxation.of(Elasticity.of(lattice), branches)
        solver = ContactSolver(
            lattice, tolerance_mm=TOLERANCE_MM, point_spacing_mm=spacing, branches=branches, **options
        )
    except MagicsimError as error:
        yield from (unsolved(path, stage, NOT_AVAILABLE, str(error)) for stage in path.stages)
        return
    state: Deformation | None = None
    timing: dict[str, Any] = {} if branches is None else {"dt_s": path.stage_s}
    for stage, indenter in zip(path.stages, indenters, strict=True):
        depth = stage.depth_share * lattice.height_mm
        start = time.perf_counter()
        try:
            found = solver.solve(indenter, state, **timing)
        except ConvergenceError as error:
            yield _row(path, stage, depth, DECLARED, str(error), seconds=time.perf_counter() - start)
            continue
        except OutOfProcessorTimeError:
            raise
        except Exception as error:
            message = f"{type(error).__name__}: {error}"
            yield _row(path, stage, depth, CRASHED, message, seconds=time.perf_counter() - start)
            continue
        seconds = time.perf_counter() - start
        elasticity = None
        if relaxation is not None:
            before = state.relaxation if state is not None else None
            elasticity = relaxation.timed_elasticity(before or relaxation.rest(), dt_s=path.stage_s)
        check = verify(lattice, found, indenter, point_spacing_mm=spacing, elasticity=elasticity)
        row = _verified(path, stage, depth, found, check, seconds)
        state = found if row.outcome == VALID else state
        yield row


def unsolved(path: StressPath, stage: Stage, outcome: str, message: str) -> StressRow:
    """A row without a state."""
    return _row(path, stage, stage.depth_share * path.design.height_mm, outcome, message)


def _verified(
    path: StressPath, stage: Stage, depth: float, state: Deformation, check: Verification, seconds: float
) -> StressRow:
    faults = check.faults(TOLERANCE_MM)
    found_again = {name: value for name, value in asdict(check).items() if name in FIGURES}
    return _row(
        path, stage, depth, SILENT if faults else VALID, ", ".join(faults), seconds=seconds,
        force_n=float(state.force_n[2]), iterations=state.iterations, cutbacks=state.cutbacks,
        restarts=state.restarts, rungs=state.rungs, **found_again,
    )  # fmt: skip


def _row(
    path: StressPath, stage: Stage, depth_mm: float, outcome: str, message: str, **figures: Any  # noqa: ANN401
) -> StressRow:  # fmt: skip
    values: dict[str, Any] = dict.fromkeys(FIGURES) | {"seconds": 0.0} | figures
    return StressRow(
        group=path.group,
        label=path.label,
        contrast=path.contrast,
        poisson_ratio=path.poisson_ratio,
        friction=path.friction,
        depth_share=stage.depth_share,
        depth_mm=depth_mm,
        shear_mm=stage.shear_mm,
        twist_deg=stage.twist_deg,
        outcome=outcome,
        message=message,
        **values,
    )
