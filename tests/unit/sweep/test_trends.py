from dataclasses import replace

import pytest

from magicsim.sweep.measures import Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.verdicts import check_trends, series


def test_rows_hold_designs_that_differ_in_one_field_alone(results: list[DesignResult]):
    rows = series(results, "design.skin_mm", "shore_a")
    assert [[each.value for each in row] for row in rows] == [[27.0, 29.0], [27.0, 29.0]]
    assert series(results, "design.core_mm", "shore_a") == []  # the base itself is no point of this grid
    assert series(results, "design.wall_mm", "shore_a") == []


def test_published_trend_is_found(results: list[DesignResult]):
    checks = {each.statement: each for each in check_trends(results)}
    assert set(checks) == {
        "thicker skin, harder", "thicker skin, stiffer", "thicker skin, less sensitive to depth (our reading)",
        "thicker skin, less sensitive to force (our reading)",
    }  # fmt: skip
    flat = checks.pop("thicker skin, less sensitive to depth (our reading)")  # the fakes have the same for all designs
    assert (flat.holds, flat.ends_right, flat.change) == (False, 0, 0.0)
    assert all(each.holds and (each.series, each.steps_right) == (2, 2) for each in checks.values())


def test_change_has_the_interval_of_its_ends(results: list[DesignResult]):
    harder = check_trends(results)[0]
    half = (0.1**2 + 0.1**2) ** 0.5  # of one row; the mean of two has that over sqrt(2)
    assert (harder.change, harder.low, harder.high) == pytest.approx((2.0, 2.0 - half / 2**0.5, 2.0 + half / 2**0.5))
    assert harder.ends_clear == 2


def test_change_within_the_intervals_is_not_shown(results: list[DesignResult]):
    wide = [
        replace(each, measures=each.measures | {"shore_a": replace(each.measures["shore_a"], low=20.0, high=36.0)})
        for each in results
    ]
    found = check_trends(wide)[0]
    assert (found.ends_right, found.ends_clear, found.ends_contrary, found.holds) == (2, 0, 0, False)


def test_change_has_no_interval_where_a_design_has_none(results: list[DesignResult]):
    bare = replace(results[0], measures=results[0].measures | {"shore_a": Measured(value=27.0)})
    found = check_trends([bare, *results[1:]])[0]
    assert (found.low, found.high, found.ends_clear, found.holds) == (None, None, 1, False)


def last_of_first_row(results: list[DesignResult], value: float, half: float) -> list[DesignResult]:
    measured = Measured(value=value, low=value - half, high=value + half)
    return [results[0], replace(results[1], measures=results[1].measures | {"shore_a": measured}), *results[2:]]


def test_trend_that_one_row_clearly_breaks_is_not_shown(results: list[DesignResult]):
    found = check_trends(last_of_first_row(results, 26.5, 0.1))[0]  # +2 and -0.5: the mean is clear
    assert found.low is not None
    assert found.low > 0
    assert (found.ends_right, found.ends_contrary, found.holds) == (1, 1, False)


def test_row_that_says_nothing_does_not_refute_the_others(results: list[DesignResult]):
    found = check_trends(last_of_first_row(results, 26.9, 0.5))[0]  # +2 and -0.1 within an interval of 0.5
    assert (found.ends_right, found.ends_clear, found.ends_contrary, found.holds) == (1, 1, 0, True)


def test_trend_downwards_is_one_of_falling_values(results: list[DesignResult]):
    found = {each.statement: each for each in check_trends(results)}[
        "thicker skin, less sensitive to force (our reading)"
    ]
    assert found.high is not None
    assert found.high < 0
    assert found.holds


def test_design_without_a_value_is_in_no_row(results: list[DesignResult]):
    gap = replace(results[1], measures=results[1].measures | {"shore_a": Measured(value=None)})
    assert series([results[0], gap], "design.skin_mm", "shore_a") == []
