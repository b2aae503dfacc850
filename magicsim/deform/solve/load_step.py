"""One load step: iterations on one pose of the object, from an equilibrium under it in another.

They begin on the object's surface carried along from its last pose (`contact.augmented.moved_surface`) where it goes
a long way, so that the face follows the object before the true surface decides.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from magicsim.deform.contact.augmented import moved_surface
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.table import has_settled
from magicsim.deform.solve import newton
from magicsim.deform.solve.condensed import Condenser, FirstStep
from magicsim.deform.solve.iterate import Iterate, evaluated
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import Problem
from magicsim.deform.solve.rigid_motion import reach_mm, way_length_mm
from magicsim.geometry.indenter import Indenter

SHORT = 0.25
"""Way of the object, in units of its smallest feature, below which no point of the face changes its side of a tip."""
TABLE_UPDATES, TABLE_PATIENCE = 30, 6
"""Most updates of the limits of friction below a block on a table in one load step, and how many of them are early."""
TABLE_RESIDUALS = (0.3, 1e-2)
"""Residuals below which they are updated, early and late; updated in balance only, a base that was held too little has
slid out and has to be pulled back."""


def iterate_pose(
    problem: Problem,
    condenser: Condenser,
    indenter: Indenter,
    before: Indenter,
    start: Deformation,
    *,
    may_use_path: bool,
    note: Callable[[Iterate], None],
) -> Iterate:
    """Where the iterations on a pose end.

    Args:
        problem: The lattice, its tolerances and limits.
        condenser: Takes the steps.
        indenter: The object in its pose.
        before: The object in the pose of the last equilibrium.
        start: That equilibrium.
        may_use_path: Whether the factor that the path has left is used.
        note: Told every iteration.
    """
    problem = problem.on_table(start.table)
    nodes, pressed = problem.elasticity.lattice.nodes_mm, np.flatnonzero(start.contact_pressure_mpa > 0)
    positions, surface = nodes + start.displacements_mm, moved_surface(indenter, before)
    memory = _first_memory(problem, indenter, start)
    last = evaluated(problem, indenter.distance, positions, start.pressure_mpa, memory)
    way_mm = way_length_mm(before.pose, indenter.pose, reach_mm(start, before.pose))
    is_short = way_mm < SHORT * indenter.shape.feature_mm
    first = FirstStep(predictor=None if is_short else surface, pressed=pressed)
    condenser.begin(start.linearisation if may_use_path else None)
    found = condenser.step(problem, indenter.distance, last, first=first)
    if isinstance(found, Rung):
        state = evaluated(problem, surface, positions, start.pressure_mpa, memory)
        found = newton.step(problem, surface, state).on(found)
        if not found.stuck:
            guess = evaluated(problem, indenter.distance, found.positions, found.pressure, found.memory)
            found = replace(guess, iteration=found.iteration, shift=found.shift, rungs=found.rungs)
    note(found)
    updates = 0
    while True:
        near = TABLE_RESIDUALS[updates >= TABLE_PATIENCE]
        if found.residual <= near and updates < TABLE_UPDATES and not has_settled(found.elastic.table):
            problem, updates = problem.with_table_at(found.positions), updates + 1
            again = evaluated(problem, indenter.distance, found.positions, found.pressure, found.memory)
            found = replace(again, rungs=found.rungs)
        if newton.terminate(problem, found):
            return found
        following = condenser.step(problem, indenter.distance, found)
        if isinstance(following, Rung):
            following = newton.step(problem, indenter.distance, found).on(following)
        found = following
        note(found)


def _first_memory(problem: Problem, indenter: Indenter, start: Deformation) -> ContactMemory:
    """Multipliers of zero, see `newton`; anchors move with the object, and limits are those of the last pressures."""
    return ContactMemory(
        multipliers_mpa=np.zeros(len(start.contact_points_mm)),
        penalty=problem.first_penalty,
        anchors_mm=start.contact_points_mm if start.is_rest else indenter.pose.to_sensor(start.anchors_mm),
        limit_mpa=problem.law.friction * start.contact_pressure_mpa,
        normal=indenter.distance(start.contact_points_mm)[1],
    )
