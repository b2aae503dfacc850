"""How the object's force changes with a small motion of the object: the tangent of an equilibrium, 6 x 6.

With the object moved by a small rigid motion v(x) = t + w x x, a contact point at x that moves by N u feels the force

    df = L (v - N u) + w x f,

L being the contact's Hessian at that point and f the force there: if point and object move together, the force turns
along. The body, condensed onto the face's nodes (see `condensed`), balances it, S u = N^T df, so

    (S + N^T L N) u = N^T (L v + w x f),

and the changes of force and torque are the sums of df and of x x df + (N u) x f. Points that slide keep the limit of
their friction; that the limit itself follows the pressure is left out.
"""

import numpy as np
from scipy.linalg import LinAlgError, solve

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import add_dense_stiffness, contact_stiffness, evaluate_contact
from magicsim.deform.contact.face import gather, scatter
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.solve.body import FactorStore
from magicsim.deform.solve.problem import Problem
from magicsim.geometry.indenter import Indenter

STILL_SLIDING = 1 - 1e-6
"""Limits of sliding points in units of their own, so that rounding does not turn them into sticking ones."""
RIGID = 10.0
"""Penalty, in units of a load step's first, that stands for rigid contact: where multipliers carry the pressure, points
do not give way under the object's motion; assumed."""
CARRIED_SHARE = 0.1
"""Part of the force that multipliers carry from which contact counts as rigid: assumed."""
NEAR_MM = 0.05
"""Facets with a point nearer to the object take part [mm]: assumed."""
MOTIONS = 6


def contact_tangent(problem: Problem, store: FactorStore, state: Deformation, indenter: Indenter) -> Array | None:
    """Derivative of force and torque on the sensor by the object's motion, shape (6, 6) [N, N mm per mm, rad].

    The object is in the pose of an equilibrium, whose factor the store holds afterwards. Rows are force and torque
    about the sensor's origin, columns the motion of the object's point at the sensor's origin and its rotation about
    the sensor's axes; zero at rest, None where the body cannot be condensed there.
    """
    if state.is_rest:
        return np.zeros((MOTIONS, MOTIONS))
    positions = problem.elasticity.lattice.nodes_mm + state.displacements_mm
    memory = _memory(problem, state, indenter)
    whole = evaluate_contact(problem.face, positions, indenter.distance, memory, problem.law)
    near = state.contact_gap_mm < NEAR_MM
    near[whole.acting] = True
    linearisation = Linearisation(
        elasticity=problem.elasticity,
        positions=positions,
        pressure=state.pressure_mpa,
        volume_gradient=problem.elasticity.evaluate(positions).volume_gradient,
        shift=0.0,
        facets=np.unique(problem.face.facet[near]),
    )
    factor = store.factor(problem, linearisation)
    if factor is None:
        return None
    part, _, stiffness = factor
    own = part.memory(memory)
    contact = evaluate_contact(part.face, positions[part.nodes], indenter.distance, own, problem.law)
    acting, held = contact.acting, problem.pattern.held[part.unknowns]
    local = contact_stiffness(contact, part.face, indenter.distance, own, problem.law, curvature_limit=np.inf)
    matrix = stiffness.copy()
    add_dense_stiffness(matrix, part.face, acting, local)
    matrix[held], matrix[:, held] = 0.0, 0.0
    matrix[held, held] = 1.0
    force = part.face.area_mm2[acting, None] * contact.traction_mpa()[acting]
    points, shape, facet = contact.points_mm[acting], part.face.shape, part.face.facet
    carried, turned = [], []
    for motion, rotation in _motions(points):
        turned.append(np.cross(rotation, force))
        carried.append(np.einsum("qij,qj->qi", local, motion) + turned[-1])
    loads = np.zeros((MOTIONS, len(part.nodes), 3))
    for load, vectors in zip(loads, carried, strict=True):
        scatter(shape, facet, part.face.patches, acting, vectors, load)
    right = loads.reshape(MOTIONS, -1).T
    right[held] = 0.0
    try:
        nodes = solve(matrix, right, assume_a="sym").T.reshape(MOTIONS, -1, 3)
    except LinAlgError:
        return None
    columns = []
    for moved, vectors in zip(nodes, carried, strict=True):
        along = np.asarray(gather(shape, facet, part.face.patches, moved))[acting]
        change = vectors - np.einsum("qij,qj->qi", local, along)
        torque = np.cross(points, change) + np.cross(along, force)
        columns.append(np.concatenate([change.sum(0), torque.sum(0)]))
    return np.stack(columns, axis=1)


def _motions(points: Array) -> list[tuple[Array, Array]]:
    """Motion of the object at the points, shape (points, 3), and its rotation, shape (3,), for each unit motion."""
    unit, none = np.eye(3), np.zeros(3)
    shifts = [(np.broadcast_to(each, points.shape), none) for each in unit]
    return shifts + [(np.cross(each, points), each) for each in unit]


def _memory(problem: Problem, state: Deformation, indenter: Indenter) -> ContactMemory:
    """Memory of contact at an equilibrium: multipliers that give its pressures, anchors where they were left."""
    penalty, pressure = problem.first_penalty, state.contact_pressure_mpa
    pressed = pressure > 0
    carried = np.abs(pressure + penalty * state.contact_gap_mm)[pressed]
    area = problem.face.area_mm2[pressed]
    if area @ carried > CARRIED_SHARE * (area @ pressure[pressed]):
        penalty *= RIGID
    limit = problem.law.friction * pressure
    limit[state.is_slipping] *= STILL_SLIDING
    return ContactMemory(
        multipliers_mpa=np.where(pressed, pressure + penalty * np.where(pressed, state.contact_gap_mm, 0.0), 0.0),
        penalty=penalty,
        anchors_mm=indenter.pose.to_sensor(state.anchors_mm),
        limit_mpa=limit,
        normal=indenter.distance(state.contact_points_mm)[1],
    )
