"""A move that is interrupted anywhere leaves the solver as it was: the next one has the same bits."""

from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest
from laboratory.interrupts import Place, interrupt, watched

from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.solve import body, condensed, factorise, pardiso
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

LATTICE = box_lattice(
    (np.linspace(-4, 4, 7), np.linspace(-4, 4, 7), np.linspace(0, 4, 4)), shear_modulus_mpa=0.1, lame_mpa=1.0
)
STATEFUL = {module.__file__ for module in (body, condensed, factorise, pardiso)}
"""Files of what keeps something from one solve to the next."""


def ball(depth_mm: float, x_mm: float = 0.0) -> Indenter:
    return place_object(parse_object("sphere:radius_mm=3"), gap_mm=-depth_mm, x_mm=x_mm)


END = ball(1.2, 0.8)


@pytest.fixture(scope="module")
def moved() -> SimpleNamespace:
    """A solver with friction, an equilibrium, a move from it, and what it comes to."""
    solver = ContactSolver(LATTICE, friction=0.5, max_step_mm=0.4)
    before = solver.solve(ball(0.3))
    lines: list[Place] = []
    watched(lambda: solver.solve(END, before), lines.append)
    kept = [place for place in lines if place[0] in STATEFUL]
    return SimpleNamespace(solver=solver, before=before, after=solver.solve(END, before), lines=kept)


def interrupted(moved: SimpleNamespace, place: Place, nth: int) -> None:
    """Raises KeyboardInterrupt the nth time that a line is about to run."""
    assert interrupt(lambda: moved.solver.solve(END, moved.before), place, nth, KeyboardInterrupt)


def assert_same(moved: SimpleNamespace, place: Place) -> None:
    again = moved.solver.solve(END, moved.before)
    assert np.array_equal(again.displacements_mm, moved.after.displacements_mm), place
    assert np.array_equal(again.force_n, moved.after.force_n), place


def test_move_repeats_to_the_bit(moved: SimpleNamespace):
    assert len(set(moved.lines)) > 100
    assert_same(moved, ("nowhere", 0))


def test_interrupt_in_any_factorisation_changes_nothing(moved: SimpleNamespace, monkeypatch: pytest.MonkeyPatch):
    owner = type(moved.solver._condenser.store._condenser)
    whole, wanted, nth = owner.factorise, 1, 0

    def stop(self: object, values: np.ndarray) -> np.ndarray | None:
        nonlocal nth
        nth += 1
        stiffness = whole(self, values)
        if nth == wanted:
            raise KeyboardInterrupt
        return stiffness

    while True:  # as many as there are
        nth = 0
        with monkeypatch.context() as patch, suppress(KeyboardInterrupt):
            patch.setattr(owner, "factorise", stop)
            moved.solver.solve(END, moved.before)
        assert_same(moved, ("factorise", wanted))
        if nth < wanted:
            break
        wanted += 1
    assert wanted > 3


@pytest.mark.slow
def test_interrupt_at_any_line_that_keeps_something_changes_nothing(moved: SimpleNamespace):
    counts = {place: moved.lines.count(place) for place in dict.fromkeys(moved.lines)}
    for place, count in counts.items():
        for nth in sorted({1, count}):
            interrupted(moved, place, nth)
            assert_same(moved, place)
