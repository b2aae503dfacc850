"""Contact solved in full on the face: the same equilibria as plain Newton steps find, in fewer factorisations."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve import body as factors
from magicsim.deform.solve import condensed as condensed_steps
from magicsim.deform.solve import face_part, face_problem
from magicsim.deform.solve import factorise as linear
from magicsim.deform.solve.body import FactorStore
from magicsim.deform.solve.condensed import Condenser
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")
PLACES = ((-0.3, 0.0, 0.0), (-0.8, 0.0, 0.0), (-0.8, 0.4, 0.0), (-0.8, 0.4, 20.0))
"""Gap [mm], place along x [mm], turn [degrees]: pressed, pressed deeper, moved along, twisted."""
TIGHT_MM = 1e-5


def block(side_mm: float) -> Lattice:
    design = [f"footprint_mm=[{side_mm}, {side_mm}]", "core_mm=4.0", "wall_mm=0.2", "lattice.spacing_mm=1.0"]
    design += ["materials.body.youngs_modulus_mpa=1.523"]
    return build_lattice(load_preset(ElastomerDesign, "design", "mini-magictac", design))


@pytest.fixture(scope="module")
def lattice() -> Lattice:
    return block(12.0)


def solved(solver: ContactSolver, poses: list[Indenter]) -> list[Deformation]:
    states: list[Deformation] = []
    for pose in poses:
        states.append(solver.solve(pose, states[-1] if states else None))
    return states


def poses() -> list[Indenter]:
    return [place_object(BALL, gap_mm=gap, x_mm=x, twist_deg=turn) for gap, x, turn in PLACES]


@pytest.mark.parametrize("friction", [0.0, pytest.param(0.6, marks=pytest.mark.slow)])
def test_equilibria_are_those_of_plain_newton_steps(friction: float, monkeypatch: pytest.MonkeyPatch) -> None:
    lattice = block(16.0 if friction else 12.0)  # near the rim of a contact that slips, friction has many equilibria
    condensed = solved(ContactSolver(lattice, tolerance_mm=TIGHT_MM, friction=friction), poses())
    monkeypatch.setattr(Condenser, "step", lambda *_, **__: Rung.LARGE)
    plain = solved(ContactSolver(lattice, tolerance_mm=TIGHT_MM, friction=friction), poses())
    tolerance = 2e-3 if friction else 1e-4
    for one, other in zip(condensed, plain, strict=True):
        size = np.linalg.norm(other.force_n)
        np.testing.assert_allclose(one.force_n, other.force_n, atol=tolerance * size)
        np.testing.assert_allclose(one.displacements_mm, other.displacements_mm, atol=tolerance)
    assert 2 * sum(state.iterations for state in condensed) < sum(state.iterations for state in plain)


def test_what_was_solved_before_changes_no_bit(lattice: Lattice) -> None:
    fresh, used = (ContactSolver(lattice, friction=0.6) for _ in range(2))
    solved(used, [place_object(parse_object("box:size_mm=5"), gap_mm=-0.4, x_mm=1.0)])
    for one, other in zip(solved(fresh, poses()), solved(used, poses()), strict=True):
        np.testing.assert_array_equal(one.displacements_mm, other.displacements_mm)


def test_contacts_too_large_to_condense_are_plain_steps_with_all_their_iterations(
    lattice: Lattice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(factors, "MAX_UNKNOWNS", 0)
    monkeypatch.setattr(condensed_steps, "GIVEN_UP_SHARE", 0.0)
    large = solved(ContactSolver(lattice), poses()[:2])
    monkeypatch.setattr(Condenser, "step", lambda *_, **__: Rung.LARGE)
    plain = solved(ContactSolver(lattice), poses()[:2])
    for one, other in zip(large, plain, strict=True):
        np.testing.assert_array_equal(one.displacements_mm, other.displacements_mm)


@pytest.mark.parametrize(
    ("owner", "name", "value", "reason"),
    [
        (factors, "MAX_UNKNOWNS", 0, "large"),
        (condensed_steps, "solve_face", lambda *_, **__: None, "unsolved"),
        (FactorStore, "factor", lambda *_, **__: None, "indefinite"),
    ],
)
def test_a_result_says_why_its_steps_were_plain(
    lattice: Lattice, monkeypatch: pytest.MonkeyPatch, owner: object, name: str, value: object, reason: str
) -> None:
    assert solved(ContactSolver(lattice), poses()[:1])[0].rungs == ()
    monkeypatch.setattr(owner, name, value)
    assert solved(ContactSolver(lattice), poses()[:1])[0].rungs[:2] == ("plain", reason)


@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.slow), 0.6])
def test_thrift_of_large_contacts_changes_no_equilibrium(
    lattice: Lattice, friction: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    tight_mm = TIGHT_MM if friction else TIGHT_MM / 10
    usual = solved(ContactSolver(lattice, tolerance_mm=tight_mm, friction=friction), poses())
    for module in (face_part, face_problem):
        monkeypatch.setattr(module, "LARGE", 0)
    thrifty = solved(ContactSolver(lattice, tolerance_mm=tight_mm, friction=friction), poses())
    tolerance = 1e-3 if friction else 1e-6
    for one, other in zip(thrifty, usual, strict=True):
        np.testing.assert_allclose(one.force_n, other.force_n, atol=tolerance * np.linalg.norm(other.force_n))
        np.testing.assert_allclose(one.displacements_mm, other.displacements_mm, atol=tolerance)


def test_a_cylinder_that_lies_askew_is_condensed() -> None:
    """Its contact is as long as the face: plain steps of body and contact together would take three times as long."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[16.0, 16.0]", "core_mm=4.0"])
    pose = place_object(parse_object("cylinder:radius_mm=7.5,length_mm=100,axis=y"), gap_mm=-0.3, twist_deg=30.0)
    lattice = build_lattice(design, zone=contact_zone([pose], design))
    state = ContactSolver(lattice, friction=0.6).solve(pose)
    assert "plain" not in state.rungs
    assert state.iterations < 15


def test_a_tall_block_that_the_object_alone_holds_needs_no_shift() -> None:
    """Without the ball on it the bulging block would be unstable; elimination of all but its face is not."""
    overrides = ["footprint_mm=[12.0, 12.0]", "skin_mm=1.0", "core_mm=18.0", "cell_mm=0.8", "wall_mm=0.2"]
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [*overrides, "lattice.spacing_mm=1.0"])
    pose = place_object(BALL, gap_mm=-5.0)
    state = ContactSolver(build_lattice(design, zone=contact_zone([pose], design))).solve(pose)
    assert state.shifted == 0
    assert state.iterations < 80


def test_without_pardiso_the_same_iterations_find_the_same_equilibria(
    lattice: Lattice, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = solved(ContactSolver(lattice, tolerance_mm=TIGHT_MM, friction=0.6), poses()[:3])
    monkeypatch.setattr(linear, "has_pardiso", lambda: False)
    found = solved(ContactSolver(lattice, tolerance_mm=TIGHT_MM, friction=0.6), poses()[:3])
    for one, other in zip(found, expected, strict=True):
        assert abs(one.iterations - other.iterations) <= 2
        np.testing.assert_allclose(one.force_n, other.force_n, atol=2e-3 * np.linalg.norm(other.force_n))


def test_small_steps_of_a_path_share_factors(lattice: Lattice) -> None:
    solver = ContactSolver(lattice, friction=0.6)
    state = solver.solve(place_object(BALL, gap_mm=-0.6))
    made = solver.factorisations
    forces = [state.force_n]
    for number in range(1, 6):
        state = solver.solve(place_object(BALL, gap_mm=-0.6, x_mm=1e-4 * number), state)
        forces.append(state.force_n)
    assert solver.factorisations <= made + 2
    along = np.diff([force[0] for force in forces])
    np.testing.assert_allclose(along, along.mean(), rtol=0.2)


def test_a_path_begun_again_in_another_solver_gives_the_same_bits(lattice: Lattice) -> None:
    """A state carries all that its successors depend on: not the solver that found it."""
    whole = solved(ContactSolver(lattice, friction=0.6), poses())
    for start in (1, 2):
        other = ContactSolver(lattice, friction=0.6)
        state = whole[start]
        for pose, expected in zip(poses()[start + 1 :], whole[start + 1 :], strict=True):
            state = other.solve(pose, state)
            np.testing.assert_array_equal(state.displacements_mm, expected.displacements_mm)
