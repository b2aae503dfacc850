"""What is tried when a path cannot be followed, and what is no answer."""

import numpy as np
import pytest

from magicsim.bench.stress.cases import grid_paths
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.solve.path import RESTARTS, ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

LATTICE = box_lattice(
    (np.linspace(-4, 4, 9), np.linspace(-4, 4, 9), np.linspace(0, 4, 5)), shear_modulus_mpa=0.1, lame_mpa=1.0
)
BALL = place_object(parse_object("sphere:radius_mm=2"), gap_mm=-0.3)


def refusing(times: int, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Lets the first attempts fail; returns a list that fills with the fineness of every attempt."""
    attempts: list[float] = []
    follow = ContactSolver._follow_path

    def refuse(self, problem, indenter, start, effort, *, fineness):
        attempts.append(fineness)
        state = follow(self, problem, indenter, start, effort, fineness=fineness)
        return state if len(attempts) > times else None

    monkeypatch.setattr(ContactSolver, "_follow_path", refuse)
    return attempts


@pytest.mark.parametrize("failures", [0, 1, 2])
def test_a_path_is_begun_again_with_longer_and_then_with_shorter_steps(
    failures: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = ContactSolver(LATTICE).solve(BALL)
    attempts = refusing(failures, monkeypatch)
    found = ContactSolver(LATTICE).solve(BALL)
    assert attempts == [1, *RESTARTS][: failures + 1]
    assert found.restarts == failures
    assert RESTARTS[0] < 1 < RESTARTS[1]
    np.testing.assert_allclose(found.force_n[2], expected.force_n[2], rtol=5e-3)  # penetration of 2 of 300 um


@pytest.mark.parametrize(("friction", "tries"), [(0.0, 1 + len(RESTARTS)), (0.5, 1)])
def test_a_path_with_friction_is_not_begun_again(friction: float, tries: int, monkeypatch: pytest.MonkeyPatch) -> None:
    attempts = refusing(9, monkeypatch)
    with pytest.raises(ConvergenceError, match="did not reach a valid equilibrium"):
        ContactSolver(LATTICE, friction=friction).solve(BALL)
    assert len(attempts) == tries


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
