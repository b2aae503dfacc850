"""Poses in sequence: warm starts, sub-steps, cut-backs, and the check that what comes out is valid."""

import logging
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from magicsim.deform import newton
from magicsim.deform.deformation import Deformation
from magicsim.deform.energy import Elasticity
from magicsim.deform.face import contact_face
from magicsim.deform.lattice import Lattice
from magicsim.deform.linear import quiet_openblas, symmetric_solver
from magicsim.deform.newton import Iterate, NewtonOptions, Problem
from magicsim.deform.pattern import block_pattern
from magicsim.errors import ConvergenceError
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose

Array = npt.NDArray[np.float64]
LOGGER = logging.getLogger(__name__)
MAX_BALANCE = 1e-6
"""Largest relative difference between contact force and reaction that is accepted."""

TOUCHING_SHARE = 0.01
"""Gap, in units of the smallest cell edge, that still counts as contact area: a coarse face leaves such gaps."""


class ContactSolver:
    """Solves one lattice for any sequence of objects and poses; keeps the factorisation's analysis."""

    def __init__(self, lattice: Lattice, *, tolerance_mm: float = 0.002, max_step_mm: float = 0.5) -> None:
        """Prepares a lattice.

        Args:
            lattice: The block.
            tolerance_mm: Largest penetration at any contact point [mm].
            max_step_mm: Longest motion of the object between two load steps [mm]; halved where a step fails.
        """
        self.lattice = lattice
        self.max_step_mm = max_step_mm
        face = contact_face(lattice)
        pattern = block_pattern(lattice, face.patches)
        self._problem = Problem(
            elasticity=Elasticity.of(lattice),
            face=face,
            pattern=pattern,
            solver=symmetric_solver(pattern.indptr, pattern.indices),
            options=NewtonOptions(tolerance_mm=tolerance_mm),
        )
        self._rest = Deformation.rest(lattice)

    def solve(self, indenter: Indenter, previous: Deformation | None = None) -> Deformation:
        """Equilibrium with the object in a pose, reached from a previous one or from first contact.

        Args:
            indenter: The object in its pose.
            previous: Where the path stands; None starts from rest.

        Returns:
            A valid deformation; the rest state, without a solve, when the object touches no point of the undeformed
            face.

        Raises:
            ConvergenceError: No valid equilibrium was found; the message has the figures.
        """
        if not self.can_touch(indenter):
            return self._rest
        start = previous if previous is not None and previous.pose is not None else None
        first = start.pose if start is not None and start.pose is not None else _first_contact(indenter)
        with quiet_openblas():
            return self._follow_path(indenter, first, start or self._rest)

    def can_touch(self, indenter: Indenter) -> bool:
        """Whether any point of the undeformed contact face lies inside the object."""
        if indenter.top_mm() <= 0:
            return False
        return bool((indenter.distance(self._rest.contact_points_mm)[0] < 0).any())

    def _follow_path(self, indenter: Indenter, first: Pose, start: Deformation) -> Deformation:
        touching = start.contact_points_mm[start.contact_traction_mpa > 0] - first.position_mm
        reach = float(np.linalg.norm(touching[:, :2], axis=1).max(initial=0.0))
        count = max(1, int(np.ceil(_pose_distance(first, indenter.pose, reach) / self.max_step_mm - 1e-9)))
        state, done, stride, iterations = start, 0.0, 1.0 / count, 0
        shortest = stride / 32
        while done < 1:
            target = 1.0 if done + stride > 1 - 1e-9 else done + stride
            pose = indenter.pose if target == 1 else _between(first, indenter.pose, target)
            moved = replace(indenter, pose=pose)
            iterate = self._solve_pose(moved, state)
            iterations += iterate.iteration
            if newton.has_converged(self._problem, iterate) and _balance(self._problem, iterate) <= MAX_BALANCE:
                state, done = self._result(iterate, pose, iterations), target
                stride = min(stride * 1.5, 1.0 / count)
                continue
            stride /= 2
            if stride < shortest:
                raise ConvergenceError(_report(self._problem, iterate, iterations))
        return state

    def _solve_pose(self, indenter: Indenter, start: Deformation) -> Iterate:
        positions = self.lattice.nodes_mm + start.displacements_mm
        iterate = newton.init(self._problem, indenter, positions, start.pressure_mpa, start.multipliers_mpa)
        while not newton.terminate(self._problem, iterate):
            iterate = newton.step(self._problem, indenter, iterate)
            LOGGER.debug(
                "iteration %d: residual %.2e, penetration %.2e mm, min J %.3f, shift %.3g",
                iterate.iteration, iterate.residual, iterate.contact.max_penetration_mm,
                iterate.elastic.min_jacobian, iterate.shift,
            )  # fmt: skip
        return iterate

    def _result(self, iterate: Iterate, pose: Pose, iterations: int) -> Deformation:
        contact, face = iterate.contact, self._problem.face
        forces = (face.area_mm2 * contact.traction_mpa)[:, None] * contact.normal
        tolerance = self._problem.options.tolerance_mm
        touching = contact.gap_mm <= max(tolerance, TOUCHING_SHARE * self._problem.smallest_edge_mm)
        return Deformation(
            displacements_mm=iterate.positions - self.lattice.nodes_mm,
            pressure_mpa=iterate.pressure,
            multipliers_mpa=iterate.multipliers,
            contact_points_mm=contact.points_mm,
            contact_traction_mpa=contact.traction_mpa,
            contact_gap_mm=contact.gap_mm,
            pose=pose,
            force_n=forces.sum(0),
            torque_nmm=np.cross(contact.points_mm, forces).sum(0),
            contact_area_mm2=float(face.current_area_mm2(iterate.positions)[touching].sum()),
            max_penetration_mm=contact.max_penetration_mm,
            min_jacobian=iterate.elastic.min_jacobian,
            force_balance=_balance(self._problem, iterate),
            iterations=iterations,
            unknowns=self._problem.pattern.size,
            converged=True,
        )


def _first_contact(indenter: Indenter) -> Pose:
    """The pose lowered until the object's highest point is level with the undeformed face."""
    return replace(indenter.pose, position_mm=indenter.pose.position_mm - [0.0, 0.0, indenter.top_mm()])


def _pose_distance(first: Pose, last: Pose, reach_mm: float) -> float:
    """Length of the way of the object's origin and of its points at a distance from the vertical through it [mm]."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).magnitude()
    return float(np.linalg.norm(last.position_mm - first.position_mm) + turn * reach_mm)


def _between(first: Pose, last: Pose, share: float) -> Pose:
    """Pose on the straight way, turning about one axis."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).as_rotvec()
    rotation = Rotation.from_rotvec(share * turn).as_matrix() @ first.rotation
    return Pose(position_mm=(1 - share) * first.position_mm + share * last.position_mm, rotation=rotation)


def _balance(problem: Problem, iterate: Iterate) -> float:
    applied = iterate.contact.node_force_n.sum(0)
    reaction = iterate.elastic.gradient[problem.elasticity.lattice.free_nodes :].sum(0)
    size = float(np.linalg.norm(applied))
    return float(np.linalg.norm(applied + reaction)) / size if size > 0 else 0.0


def _report(problem: Problem, iterate: Iterate, iterations: int) -> str:
    return (
        f"the deformation did not reach a valid equilibrium after {iterations} iterations: residual "
        f"{iterate.residual:.2g} (at most {problem.options.residual:g}), min J {iterate.elastic.min_jacobian:.3g} "
        f"(above 0), penetration {iterate.contact.max_penetration_mm:.3g} mm (at most "
        f"{problem.options.tolerance_mm:g} mm), force balance {_balance(problem, iterate):.2g} (at most "
        f"{MAX_BALANCE:g})"
    )
