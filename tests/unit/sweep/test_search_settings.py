import sys
from dataclasses import replace
from pathlib import Path

import pytest

from magicsim.errors import ConfigError
from magicsim.sweep.comparison import run_sweep
from magicsim.sweep.measures import Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import SearchLimit, SearchSettings
from sweep.fakes import small_sweep
from sweep.searched import QUADRATIC, searching


def test_excess_is_how_far_a_design_is_out_of_the_range(results: list[DesignResult]):
    result = replace(results[0], measures={"shore_a": Measured(value=30.0), "unknowns": Measured(value=None)})
    limit = SearchLimit(measure="shore_a", low=25.0, high=28.0)
    assert limit.excess(result) == 2.0
    assert SearchLimit(measure="shore_a", low=31.0).excess(result) == 1.0
    assert SearchLimit(measure="shore_a", high=32.0).excess(result) == -2.0
    assert SearchLimit(measure="unknowns", high=1.0).excess(result) is None
    assert not SearchSettings(limits=(limit,)).keeps(result)
    assert not SearchSettings(limits=(SearchLimit(measure="unknowns", high=1.0),)).keeps(result)
    assert SearchSettings(limits=(SearchLimit(measure="shore_a", high=30.0),)).keeps(result)


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        (["search.batch=4"], "search is not allowed with sampling = 'grid'"),
        (["sampling='search'"], "count is missing"),
        (["sampling='search'", "count=8", "objectives=[]"], "objectives = [] is not allowed"),
        (["sampling='search'", "count=8", "search.batch=0"], "search.batch = 0 is not allowed"),
        (["sampling='search'", "count=8", "search.limits=[{measure='unknowns'}]"], "needs low or high"),
        (["sampling='search'", "count=8", "search.limits=[{measure='unknwns',low=1}]"], "did you mean 'unknowns'"),
        (["sampling='search'", "count=8", "search.limits=[{measure='unknowns',low=2,high=1}]"], "at most high = 1"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(settings: list[str], named: str):
    with pytest.raises(ConfigError) as error:
        small_sweep(*settings)
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_limit_of_a_measure_that_is_not_taken_is_refused():
    with pytest.raises(ConfigError, match="unknown limit 'shore_a'"):
        searching(8, "search.limits=[{measure='shore_a',high=30}]")


def test_hash_knows_the_objectives_of_a_search():
    base = searching(8).config_hash()
    assert searching(8, "objectives=[{measure='unknowns'}]").config_hash() != base
    assert searching(8, "timeout_s=1").config_hash() == base
    assert searching(8, batch=2).config_hash() != base


def test_missing_package_is_one_line_that_says_how_to_get_it(out: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(ConfigError) as error:
        run_sweep(searching(8), out, judge=QUADRATIC)
    assert str(error.value) == "sampling = 'search' needs the package optuna: pip install 'magicsim[search]'"
    assert not out.exists()
