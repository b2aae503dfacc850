"""The search for balance along the closing axis, between springs that rise as contacts do."""

from types import SimpleNamespace

import pytest

from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.pair import BALANCE_N, float_between

RADIUS_MM, DEEPEST_MM = 4.0, 2.0


class Springs:
    """A ball between two springs, in the place of the fingers."""

    def __init__(self, upper_n: float, lower_n: float, power: float) -> None:
        self.stiff_n, self.power, self.tried = (upper_n, lower_n), power, []
        space = SimpleNamespace(gap_mm=(-DEEPEST_MM, 30.0))
        self.upper, self.lower = (SimpleNamespace(workspace=space, deformation=None) for _ in range(2))
        self.now = (0.0, 0.0)

    def reaches_mm(self, place: ObjectPlace) -> tuple[float, float]:
        return RADIUS_MM, RADIUS_MM

    def put(self, place: ObjectPlace, width_mm: float) -> None:
        self.go_back(tuple(max(0.0, RADIUS_MM + side * place.z_mm - width_mm / 2) for side in (1, -1)))
        self.tried.append(max(self.now))

    def moments(self) -> tuple[float, ...]:
        return self.now

    def go_back(self, moment: tuple[float, ...]) -> None:
        self.now = moment
        for finger, stiff, depth in zip((self.upper, self.lower), self.stiff_n, moment, strict=True):
            finger.deformation = SimpleNamespace(force_n=(0.0, 0.0, stiff * depth**self.power))

    @property
    def imbalance_n(self) -> float:
        return self.upper.deformation.force_n[2] - self.lower.deformation.force_n[2]


@pytest.mark.parametrize("power", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.8, 1.0, 1.5, 5.0, 50.0])
def test_object_rests_where_both_forces_are_equal_after_few_trials(ratio: float, power: float):
    pair, width = Springs(5.0 * ratio, 5.0, power), 2 * RADIUS_MM - 1.2
    place = float_between(pair, ObjectPlace(), width)
    assert abs(pair.imbalance_n) <= BALANCE_N
    assert pair.now == pytest.approx(tuple(RADIUS_MM + side * place.z_mm - width / 2 for side in (1, -1)))
    if 0.3 <= ratio <= 5:
        assert len(pair.tried) <= 7
        assert max(pair.tried) < 1.1  # 0.6 mm each in the middle, 1.2 mm of one at the end


def test_pressed_object_that_cannot_get_to_balance_stops_at_the_workspace():
    pair = Springs(500.0, 0.01, 1.5)
    place = float_between(pair, ObjectPlace(), 2 * RADIUS_MM - 3.0)
    assert max(pair.now) == pytest.approx(DEEPEST_MM)
    assert place.z_mm == pytest.approx(-0.5)


def test_finger_that_comes_first_pushes_the_object_along():
    pair = Springs(5.0, 5.0, 1.5)
    assert float_between(pair, ObjectPlace(z_mm=3.0), 2 * RADIUS_MM + 2.0).z_mm == pytest.approx(1.0)
    assert pair.now == (0.0, 0.0)
