"""Runs the stress grid and records every case: valid, declared as failed, or silently invalid.

Whether a state is valid is found from its displacements alone and not from what the solver says about itself. A path
has a limit in processor seconds, so that what is out of time does not depend on who else uses the machine.
"""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from laboratory.stress.cases import Stage, StressPath
from magicsim.arrays import Array
from magicsim.deform.contact.face import POINT_SPACING_MM, contact_face, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_POINTS
from magicsim.deform.lattice.relaxation import Relaxation
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError, MagicsimError
from magicsim.geometry.indenter import Indenter

TOLERANCE_MM = 0.002
VALID, DECLARED, SILENT = "valid", "declared failure", "silent invalid"
NOT_AVAILABLE, CRASHED, TIMED_OUT = "not available", "crashed", "timed out"
OUTCOMES = (VALID, DECLARED, SILENT, CRASHED, TIMED_OUT, NOT_AVAILABLE)
"""Only the first two are what a solver may do."""
FIGURES = (
    "force_n", "iterations", "cutbacks", "restarts", "rungs", "min_jacobian", "penetration_mm", "force_balance",
    "interior_residual",
)  # fmt: skip
"""Figures of a state in a row."""
JUDGED_SHARE = 0.5
"""Depth in units of the height up to which cases count towards the share that is valid."""
PENETRATION_SLACK = 1.001
"""Penetration that passes, in units of the tolerance: rounding alone."""
PIERCED_SHARE = 0.01
"""Share of the pressures that push back, of their sum over all contact points, below which nothing presses back."""
MAX_BALANCE = 1e-5
"""Out-of-balance force that passes, in units of the contact force."""


class OutOfProcessorTimeError(Exception):
    """The processor time of a path is used up."""


@contextmanager
def processor_limit(seconds: float) -> Iterator[None]:
    """Ends what runs inside after processor seconds of this process; in its main thread, on Unix.

    Args:
        seconds: Of all threads together [s].

    Raises:
        OutOfProcessorTimeError: Between two instructions of Python, so that a long call of a library ends first.
    """

    def stop(*_: object) -> None:
        msg = f"took longer than {seconds:g} s of processor time"
        raise OutOfProcessorTimeError(msg)

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Figures of a state, recomputed from its displacements."""

    min_jacobian: float
    """Smallest ratio of volumes at any Gauss point."""
    penetration_mm: float
    """Deepest contact point inside the object."""
    force_balance: float
    """|the state's contact force + reaction at the bonded plane| / |contact force|."""
    interior_residual: float
    """Largest force on a free node off the contact face, over the contact force."""
    normal_share: float
    """Share of the pressures that push back, friction aside, by which a wedge may hold itself against a pull; an object
    that has pierced the face is only squeezed."""

    def faults(self, tolerance_mm: float) -> tuple[str, ...]:
        """Rules that a state breaks, empty where it is valid.

        Args:
            tolerance_mm: Penetration asked for [mm].
        """
        checks = {
            f"min J {self.min_jacobian:.3g}": self.min_jacobian > 0,
            f"penetration {self.penetration_mm:.3g} mm": self.penetration_mm <= PENETRATION_SLACK * tolerance_mm,
            f"force balance {self.force_balance:.2g}": self.force_balance <= MAX_BALANCE,
            f"interior residual {self.interior_residual:.2g}": self.interior_residual <= MAX_BALANCE,
            f"normal share of the pressures {self.normal_share:.2g}": self.normal_share > PIERCED_SHARE,
        }
        return tuple(words for words, passes in checks.items() if not passes)


def verify(
    lattice: Lattice,
    state: Deformation,
    indenter: Indenter,
    *,
    point_spacing_mm: float = POINT_SPACING_MM,
    elasticity: Elasticity | None = None,
) -> Verification:
    """Recomputes Jacobians, penetration and balance.

    Args:
        lattice: The block.
        state: What the solver returned.
        indenter: The object in its pose.
        point_spacing_mm: Of the contact points that the solver was asked for [mm].
        elasticity: Energy of the body at the end of a step that takes time; None is the lattice's own.
    """
    positions = lattice.nodes_mm + state.displacements_mm
    gradient = (elasticity or Elasticity.of(lattice)).evaluate(positions).gradient
    force = max(float(np.linalg.norm(state.force_n)), 1e-300)
    reaction = gradient[lattice.free_nodes :].sum(0)
    inside = gradient[lattice.layer_nodes : lattice.free_nodes]
    touching = bool(np.any(state.force_n))
    face = contact_face(lattice, point_spacing_mm=point_spacing_mm)
    gap, normal = indenter.distance(face.positions(positions))
    pressing = face.area_mm2 * state.contact_pressure_mpa
    return Verification(
        min_jacobian=float(volume_ratios(lattice.nodes_mm[lattice.cells], positions[lattice.cells]).min()),
        penetration_mm=max(0.0, -float(gap.min())),
        force_balance=float(np.linalg.norm(state.force_n + reaction)) / force if touching else 0.0,
        interior_residual=float(np.linalg.norm(inside, axis=1).max(initial=0.0)) / force if touching else 0.0,
        normal_share=float(pressing @ normal[:, 2] / pressing.sum()) if touching and pressing.any() else 0.0,
    )


def volume_ratios(rest_mm: Array, deformed_mm: Array) -> Array:
    """Deformed over rest volume at the 2 x 2 x 2 Gauss points of trilinear cells of any shape.

    Args:
        rest_mm: Corners at rest, x fastest and z slowest, shape (cells, 8, 3) [mm].
        deformed_mm: The same corners deformed, shape (cells, 8, 3) [mm].

    Returns:
        Determinants of the deformation gradient, shape (cells, 8).
    """
    return np.asarray(_mapped_volume(deformed_mm) / _mapped_volume(rest_mm))


def _mapped_volume(corners: Array) -> Array:
    """Determinant of the map from the unit cube, from differences along its edges, shape (cells, 8)."""
    cube = corners.reshape(-1, 2, 2, 2, 3)  # z, y, x
    volumes = np.empty((len(corners), 8))
    for number, (x, y, z) in enumerate(GAUSS_POINTS):
        wx, wy, wz = np.array([1 - x, x]), np.array([1 - y, y]), np.array([1 - z, z])
        along_x = np.einsum("cjki,j,k->ci", cube[:, :, :, 1] - cube[:, :, :, 0], wz, wy)
        along_y = np.einsum("cjki,j,k->ci", cube[:, :, 1] - cube[:, :, 0], wz, wx)
        along_z = np.einsum("cjki,j,k->ci", cube[:, 1] - cube[:, 0], wy, wx)
        volumes[:, number] = np.einsum("ci,ci->c", along_x, np.cross(along_y, along_z))
    return volumes


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
    """Objection of the solver or of the verification."""
    force_n: float | None
    """Along z."""
    iterations: int | None
    cutbacks: int | None
    restarts: int | None
    rungs: tuple[str, ...] | None
    """Rungs that the solve took beyond the ordinary path, see `magicsim.deform.solve.ladder`."""
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
