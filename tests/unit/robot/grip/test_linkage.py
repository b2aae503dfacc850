import math

import pytest

from magicsim.errors import ConfigError
from magicsim.robot.grip.linkage import Linkage

UNIT = Linkage(link_mm=50, pivot_mm=20, pad_mm=10, least_deg=-10, most_deg=40, speed_deg_s=30)


@pytest.mark.parametrize(("angle_deg", "width_mm", "along_mm"), [(0, 20, 50), (30, 70, 50 * math.sqrt(3) / 2)])
def test_distance_and_way_follow_the_parallelogram(angle_deg: float, width_mm: float, along_mm: float):
    assert UNIT.width_mm(angle_deg) == pytest.approx(width_mm)
    assert UNIT.along_mm(angle_deg) == pytest.approx(along_mm)
    assert UNIT.angle_deg(width_mm) == pytest.approx(angle_deg, abs=1e-9)


def test_tips_move_on_circles():
    for angle in (-5.0, 12.0, 39.0):
        from_motor = UNIT.width_mm(angle) / 2 + UNIT.pad_mm - UNIT.pivot_mm
        assert math.hypot(from_motor, UNIT.along_mm(angle)) == pytest.approx(50)


def test_cranks_turn_no_faster_than_they_can_and_stop_at_their_ends():
    assert UNIT.turned_deg(0, 20, dt_s=0.1) == pytest.approx(3)
    assert UNIT.turned_deg(0, -20, dt_s=0.1) == pytest.approx(-3)
    assert UNIT.turned_deg(0, 2, dt_s=0.1) == 2
    assert UNIT.turned_deg(39, 90, dt_s=1) == 40


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"link_mm": 0}, r"linkage.link_mm = 0 is not allowed: must be a number of at least 5"),
        ({"least_deg": 50}, "linkage.least_deg = 50 is not allowed: must be below most_deg = 50"),
        ({"least_deg": -20}, "fingers would pass through each other"),
    ],
)
def test_impossible_linkage_is_refused_in_one_line(values: dict[str, float], complaint: str):
    with pytest.raises(ConfigError, match=complaint) as caught:
        Linkage(**values)
    assert "\n" not in str(caught.value)


def test_width_out_of_range_names_the_range():
    with pytest.raises(ConfigError, match=r"width_mm = 150 is not allowed: must be 1.629 to 101.9"):
        Linkage().angle_deg(150)
