from dataclasses import replace

import numpy as np
import pytest

from magicsim.sweep.measures import Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import Objective
from magicsim.sweep.verdicts import columns_of, is_clear, leaders, verdicts


def within(value: float, half: float) -> Measured:
    return Measured(value=value, low=value - half, high=value + half)


def clear(larger: Measured, smaller: Measured, pairs: int = 1) -> bool:
    return bool(is_clear(columns_of([larger]), columns_of([smaller]), pairs)[0])


def with_values(base: DesignResult, name: str, values: list[Measured]) -> list[DesignResult]:
    return [replace(base, index=index, measures={name: each}) for index, each in enumerate(values)]


def verdict(base: DesignResult, name: str, values: list[Measured]) -> str | None:
    return verdicts(with_values(base, name, values), [name]).get(name)


def test_two_designs_differ_by_more_than_the_interval_of_their_difference():
    assert clear(within(1.0, 0.3), within(0.49, 0.4))  # sqrt(0.3^2 + 0.4^2) = 0.5
    assert not clear(within(1.0, 0.3), within(0.51, 0.4))
    assert not clear(within(1.0, 0.3), within(0.49, 0.4), 2)  # two pairs: wider by z(0.9875) / z(0.975) = 1.144
    assert clear(within(1.0, 0.3), within(0.42, 0.4), 2)
    lopsided = Measured(value=1.0, low=0.7, high=9.0)  # the side that faces the other counts
    assert clear(lopsided, within(0.49, 0.4))


def test_bound_is_never_clearly_above_what_it_is_open_to():
    above = Measured(value=5.0, low=4.9, note="at least")
    assert clear(above, within(3.0, 0.1))
    assert not clear(within(9.0, 0.1), above)


def test_equal_designs_are_rarely_told_apart_however_many_there_are(results: list[DesignResult]):
    random = np.random.default_rng(0)
    told = [
        verdict(results[0], "contact_auc", [within(each, 1.96) for each in random.normal(size=36)]) == "told apart"
        for _ in range(400)
    ]
    assert np.mean(told) < 0.08  # 0.05 at most; pair by pair at 0.05 it would be 1.0


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("shore_a", [within(20, 1), within(24, 1)], "told apart"),
        ("shore_a", [within(20, 3), within(24, 3)], "indistinguishable"),
        ("shore_a", [Measured(value=20.0), Measured(value=24.0)], "indistinguishable"),  # no intervals
        ("proximity_range_mm", [Measured(value=v, low=v, note="at least") for v in (100.0, 98.0)], "saturated"),
        ("proximity_range_mm", [Measured(value=100.0, low=99.0), within(64.8, 0.1)], "told apart"),
        ("proximity_range_mm", [within(64.79, 0.1)] * 3, "saturated"),
        ("dot_spacing_mm", [Measured(value=1.0, high=1.2)] * 2, "saturated"),
        ("printability", [within(1.0, 0.0)] * 2, "indistinguishable"),
        ("printability", [within(1.0, 0.0), within(0.8, 0.0)], "told apart"),
        ("shore_a", [within(20, 1), Measured(value=None)], None),
    ],
)
def test_measure_says_whether_designs_differ(results: list[DesignResult], name, values, said):
    assert verdict(results[0], name, values) == said


def test_best_is_alone_ahead_and_later_objectives_decide_between_what_is_not_told_apart(results: list[DesignResult]):
    sensitivity, localisation = Objective(measure="sensitivity_per_n"), Objective(measure="localisation_mm")
    assert [each.index for each in leaders(results[:4], [sensitivity])] == [0, 2]
    assert [each.index for each in leaders(results[:4], [sensitivity, localisation])] == [0]
    harder = Objective(measure="shore_a", better="lower")
    assert [each.index for each in leaders(results[:4], [harder])] == [0, 2]


def test_no_objective_or_no_value_names_no_best(results: list[DesignResult]):
    assert leaders(results, []) == []
    assert leaders([], [Objective(measure="unknowns")]) == []
    assert leaders(with_values(results[0], "unknowns", [Measured(value=None)]), [Objective(measure="unknowns")]) == []
