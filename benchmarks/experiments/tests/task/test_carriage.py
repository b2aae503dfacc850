from itertools import pairwise

import pytest

from magicsim_experiments.task.world import Carriage, driven

STEP = {"dt_s": 1 / 15, "most_mm_s": 150.0, "most_mm_s2": 1000.0}


@pytest.mark.parametrize("distance", [300.0, 37.0, 4.0])
def test_carriage_arrives_within_its_limits_and_stays(distance: float):
    now, speeds = Carriage(), [0.0]
    for _ in range(80):
        now = driven(now, distance, **STEP)
        speeds.append(now.speed_mm_s)
        assert now.place_mm <= distance + 1e-9
    assert (now.place_mm, now.speed_mm_s, now.acceleration_mm_s2) == (distance, 0, 0)
    assert max(speeds) <= 150
    assert max(abs(b - a) for a, b in pairwise(speeds)) <= 1000 / 15 + 1e-9


def test_it_comes_back_as_it_went():
    there, back = Carriage(), Carriage(place_mm=200.0)
    for _ in range(10):
        there, back = driven(there, 200.0, **STEP), driven(back, 0.0, **STEP)
        assert there.place_mm == pytest.approx(200 - back.place_mm)
