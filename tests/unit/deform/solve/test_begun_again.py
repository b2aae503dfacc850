"""What is tried when a path cannot be followed, and what is no answer."""

import numpy as np
import pytest
from laboratory.stress.cases import grid_paths

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.quality import NewtonOptions
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

LATTICE = box_lattice(
    (np.linspace(-4, 4, 9), np.linspace(-4, 4, 9), np.linspace(0, 4, 5)), shear_modulus_mpa=0.1, lame_mpa=1.0
)


FEW = NewtonOptions(max_iterations=3)
"""So few iterations that most paths fail."""


def pressed(
    radius_mm: float, depth_mm: float, *, longest_mm: float, options: NewtonOptions, friction: float = 0.0
) -> Deformation:
    ball = place_object(parse_object(f"sphere:radius_mm={radius_mm}"), gap_mm=-depth_mm)
    return ContactSolver(LATTICE, max_step_mm=longest_mm, options=options, friction=friction).solve(ball)


def test_a_path_that_fails_is_begun_again_with_longer_steps() -> None:
    usual = pressed(1.0, 0.6, longest_mm=0.3, options=NewtonOptions())
    found = pressed(1.0, 0.6, longest_mm=0.3, options=FEW)
    assert usual.restarts == 0
    assert found.restarts == 1
    assert found.rungs[-1] == Rung.FEWER
    np.testing.assert_allclose(found.force_n[2], usual.force_n[2], rtol=5e-3)  # penetration of 2 of 600 um


@pytest.mark.parametrize(("friction", "restarts"), [(0.0, 1), (0.5, 0)])
def test_a_path_with_friction_is_not_begun_again(friction: float, restarts: int) -> None:
    hopeless = NewtonOptions(max_iterations=1)
    with pytest.raises(ConvergenceError, match=f"did not reach a valid equilibrium .* and {restarts} restarts"):
        pressed(2.0, 0.4, longest_mm=1.0, options=hopeless, friction=friction)


def test_a_path_that_meets_its_bound_says_how_deep_it_got() -> None:
    ball = place_object(parse_object("sphere:radius_mm=2"), gap_mm=-0.8)
    told = r"bound of max_iterations = 5 .* 0\.[2-6]\d* mm deep, and 0\.8 mm were asked for: press less deep"
    with pytest.raises(ConvergenceError, match=told) as error:
        ContactSolver(LATTICE, max_step_mm=0.2, max_iterations=5).solve(ball)
    assert "\n" not in str(error.value)
    usual, bounded = (
        ContactSolver(LATTICE, max_step_mm=0.2, max_iterations=bound).solve(ball) for bound in (2000, 100)
    )
    assert usual.force_n.tobytes() == bounded.force_n.tobytes()


@pytest.mark.slow
def test_a_dome_in_a_soft_block_is_pressed_back_instead_of_piercing_its_face() -> None:
    # Newton iterations from 1.8 to 3 mm end with the shaft in a hole of the face, squeezed at its flanks alone.
    (path,) = (
        each
        for each in grid_paths()
        if each.label.startswith("domed") and each.contrast == 1 and each.poisson_ratio == 0.25
    )
    indenters = path.indenters()
    solver = ContactSolver(path.lattice(), point_spacing_mm=point_spacing_mm(indenters[0].shape))
    state = None
    forces = []
    for indenter in indenters:
        state = solver.solve(indenter, state)
        forces.append(state.force_n[2])
    assert np.all(np.diff(forces) > 1)
