import pytest
from laboratory.operating_point.targets import TARGETS, WORST, distances, total_distance

MET = {
    "s_rest": 0.85, "s_near": 0.84, "s_touch": 0.78, "s_light": 0.4,
    "s_sway": 0.01, "s_drop": 0.06, "c_back": -0.01, "c_rise": 0.2,
    "c_far": 0.2, "c_near": 0.0, "c_light": 0.95,
    "e_rest": 0.3, "e_near": 4.0, "lead_mm": 12.0,
}  # fmt: skip


def test_published_figures_are_at_distance_0():
    assert total_distance(MET) == 0
    assert set(MET) == set(TARGETS)


def test_distance_is_signed_and_in_tolerances():
    assert distances(MET | {"s_touch": 0.86})["s_touch"] == pytest.approx(2)
    assert distances(MET | {"e_near": 2.5})["e_near"] == pytest.approx(-2)


def test_one_hopeless_quantity_does_not_hide_the_others():
    hopeless = MET | {"c_near": 900.0}
    assert total_distance(hopeless) == pytest.approx(WORST / len(TARGETS) ** 0.5)
    assert total_distance(hopeless | {"e_rest": 0.8}) > total_distance(hopeless)
