"""Where motors stall, on contacts whose force is known."""

import pytest

from magicsim.robot.grip.linkage import TOLERANCE, close_until


class Hertzian:
    """Faces on a ball that they touch at 20 mm: the force goes with the power 1.5 of what is pressed in."""

    def __init__(self) -> None:
        self.width, self.kept, self.deepest, self.solved = 20.0, 20.0, 20.0, 0

    def force_n(self, width: float) -> float:
        self.width, self.deepest, self.solved = width, min(width, self.deepest), self.solved + 1
        return 10.0 * max(20.0 - width, 0.0) ** 1.5

    def keep(self) -> None:
        self.kept = self.width


@pytest.mark.parametrize("limit_n", [0.05, 3.0, 12.0, 60.0])
@pytest.mark.parametrize("target_mm", [16.0, 5.0])
def test_motors_stall_at_their_force_however_far_they_were_told_to_go(limit_n: float, target_mm: float):
    faces = Hertzian()
    assert close_until(faces.force_n, faces.keep, (20.0, 0.0), target_mm, limit_n)
    stands = 20.0 - (limit_n / 10) ** (2 / 3)
    assert 10 * (20 - faces.width) ** 1.5 == pytest.approx(limit_n, rel=TOLERANCE)
    assert faces.deepest > stands - 0.4 - 1e-9  # nothing is pressed much deeper than it is left
    assert faces.kept > stands


def test_strong_motors_reach_where_they_are_told_to_go():
    faces = Hertzian()
    assert not close_until(faces.force_n, faces.keep, (20.0, 0.0), 18.9, 50.0)
    assert faces.width == faces.kept == 18.9
    assert faces.solved == 3


def test_motors_that_are_too_weak_for_what_is_pressed_do_not_move():
    faces = Hertzian()
    assert close_until(faces.force_n, faces.keep, (19.0, 10.0), 18.0, 9.0)
    assert faces.solved == 0


def test_force_that_jumps_over_the_limit_ends_beside_the_jump():
    forces = []

    def force_n(width: float) -> float:
        forces.append(width)
        return 20.0 if width < 19.8 else 1.0

    assert close_until(force_n, lambda: None, (20.0, 0.0), 19.0, 9.0)
    assert forces[-1] == pytest.approx(19.8, abs=1e-4)
