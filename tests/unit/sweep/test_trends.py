from dataclasses import replace

from magicsim.sweep.measures import Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.trends import check_trends, series


def test_rows_hold_designs_that_differ_in_one_field_alone(results: list[DesignResult]):
    assert series(results, "design.skin_mm", "shore_a") == [[27.0, 29.0], [27.0, 29.0]]
    assert series(results, "design.core_mm", "shore_a") == []  # the base itself is no point of this grid
    assert series(results, "design.wall_mm", "shore_a") == []


def test_published_trend_is_found(results: list[DesignResult]):
    checks = {each.statement: each for each in check_trends(results)}
    assert set(checks) == {
        "thicker skin, harder", "thicker skin, stiffer", "thicker skin, less sensitive to force"
    }  # fmt: skip
    assert all(each.holds and (each.series, each.steps_right) == (2, 2) for each in checks.values())


def test_trend_that_one_row_breaks_does_not_hold(results: list[DesignResult]):
    broken = replace(results[1], measures=results[1].measures | {"shore_a": Measured(value=20.0)})
    found = check_trends([results[0], broken, *results[2:]])[0]
    assert (found.ends_right, found.series, found.holds) == (1, 2, False)


def test_design_without_a_value_is_in_no_row(results: list[DesignResult]):
    gap = replace(results[1], measures=results[1].measures | {"shore_a": Measured(value=None)})
    assert series([results[0], gap], "design.skin_mm", "shore_a") == []
