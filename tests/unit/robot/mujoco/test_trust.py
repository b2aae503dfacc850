import pytest

from magicsim.robot.mujoco.attached import LEAST_MM, MOST_MM, Trust


def test_way_grows_where_predictions_hold_and_shrinks_where_they_fail():
    trust = Trust(tolerance_n=0.02)
    assert trust.learned(0.001).way_mm > trust.way_mm
    assert trust.learned(0.5).way_mm < trust.way_mm
    assert trust.learned(0.5).worst_n == 0.5


@pytest.mark.parametrize(("error_n", "limit_mm"), [(0.0, MOST_MM), (10.0, LEAST_MM)])
def test_way_stays_within_its_limits(error_n: float, limit_mm: float):
    trust = Trust(tolerance_n=0.02)
    for _ in range(20):
        trust = trust.learned(error_n)
    assert trust.way_mm == limit_mm
