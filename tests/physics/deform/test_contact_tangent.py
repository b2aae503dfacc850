"""The tangent of an equilibrium against differences of equilibria."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.pose import Pose
from magicsim.scenes.scene import load_scene

BLOCK = [
    "design=uniform-block", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1",
    "design.lattice.cells_across=0", "object.radius_mm=6",
]  # fmt: skip


def moved(indenter: Indenter, motion: np.ndarray) -> Indenter:
    turn = Rotation.from_rotvec(motion[3:]).as_matrix()
    pose = indenter.pose
    place = Pose(position_mm=turn @ pose.position_mm + motion[:3], rotation=turn @ pose.rotation)
    return Indenter(shape=indenter.shape, pose=place)


@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.slow), 0.8])
def test_tangent_is_the_derivative_of_force_and_torque(friction: float):
    scene = load_scene("grip", BLOCK)
    pressed = place_object(scene.object, gap_mm=-0.7, x_mm=0.3, y_mm=-0.2)
    solver = ContactSolver(
        build_lattice(scene.design), friction=friction, point_spacing_mm=point_spacing_mm(pressed.shape)
    )
    state = solver.solve(pressed)
    tangent = solver.tangent(state, pressed)
    step_mm, step_rad = 0.02, 0.005
    steps = np.array([step_mm] * 3 + [step_rad] * 3)
    differences = np.zeros((6, 6))
    for number, step in enumerate(steps):
        ends = [solver.solve(moved(pressed, sign * step * np.eye(6)[number]), state) for sign in (1, -1)]
        wrenches = [np.concatenate([each.force_n, each.torque_nmm]) for each in ends]
        differences[:, number] = (wrenches[0] - wrenches[1]) / (2 * step)
    scale = np.sqrt(np.outer(np.diag(tangent), np.diag(tangent)).clip(tangent[2, 2] ** 2))
    worst = np.abs(tangent - differences) / scale
    assert worst.max() < 0.06


def test_nothing_touches_and_nothing_answers():
    scene = load_scene("grip", BLOCK)
    away = place_object(scene.object, gap_mm=1.0)
    solver = ContactSolver(build_lattice(scene.design), point_spacing_mm=point_spacing_mm(away.shape))
    assert (solver.tangent(solver.solve(away), away) == 0).all()
