import numpy as np
import pytest

from magicsim.judge.regression import corrected, exchanges, p_values, smallest_falls


def falls(differences: np.ndarray) -> np.ndarray:
    """Mean falls of units, shape (units, measures), under all exchanges."""
    return (1 - 2.0 * exchanges(len(differences), seed=0)) @ differences


def test_all_exchanges_of_few_units_and_the_observed_one_first():
    tried = exchanges(4, seed=0)
    assert len({tuple(row) for row in tried.tolist()}) == len(tried) == 16
    assert not tried[0].any()
    many = exchanges(30, seed=0)
    assert not many[0].any()
    assert many[1:].mean() == pytest.approx(0.5, abs=0.01)


def test_smallest_p_is_that_of_all_units_falling():
    p = p_values(falls(np.ones((7, 1))))
    assert p[0, 0] == 2.0**-7
    assert p.max() == 1.0


def test_measures_that_fall_together_pay_once():
    same = p_values(falls(np.ones((7, 12))))
    assert corrected(same) == pytest.approx(np.full(12, 2.0**-7))


def test_correction_lies_between_the_raw_p_and_that_of_bonferroni():
    random = np.random.default_rng(3)
    p = p_values(falls(random.standard_normal((10, 5)) + np.array([1.2, 0.8, 0.3, 0.0, 0.0])))
    adjusted = corrected(p)
    assert (adjusted >= p[0]).all()
    assert (adjusted <= np.minimum(1, 5 * p[0]) + 1e-12).all()
    assert (np.argsort(adjusted, kind="stable") == np.argsort(p[0], kind="stable")).all()
    assert adjusted.min() > p[0].min()


def test_false_alarms_of_any_measure_stay_at_the_significance():
    """Eight independent measures without a fall: 400 trials at 5 % give 20; 33 or more have a probability of 0.3 %."""
    random = np.random.default_rng(1)
    alarms = sum(corrected(p_values(falls(random.standard_normal((8, 8))))).min() < 0.05 for _ in range(400))
    assert 4 < alarms < 33


@pytest.mark.parametrize("units", [5, 6, 8, 12])
@pytest.mark.parametrize("measures", [1, 3])
def test_smallest_fall_is_where_the_test_itself_turns(units: int, measures: int):
    """All takes fall by a little more or a little less than the smallest fall, their scatter stays."""
    scattered = np.random.default_rng(units).standard_normal((units, measures))
    tried = exchanges(units, seed=0)
    shares = np.repeat(tried.mean(axis=1)[:, None], measures, axis=1)

    def corrected_p(measure: int, fall: float) -> float:
        differences = scattered.copy()
        differences[:, measure] += fall - differences[:, measure].mean()
        return float(corrected(p_values(falls(differences) / units))[measure])

    for measure, smallest in enumerate(smallest_falls(falls(scattered) / units, shares)):
        if np.isfinite(smallest):
            assert corrected_p(measure, smallest + 1e-6) < 0.05 <= corrected_p(measure, smallest - 1e-6)
        else:
            assert corrected_p(measure, 1e6) >= 0.05
            assert units == 5  # three measures that do not fall together have too many best exchanges of 32


def test_fewer_than_five_takes_find_no_fall_and_more_of_them_find_smaller_ones():
    def smallest(units: int) -> float:
        scattered = np.tile([-1.0, 1.0], units)[:units, None]
        shares = exchanges(units, seed=0).mean(axis=1)[:, None]
        return float(smallest_falls(falls(scattered) / units, shares)[0])

    assert smallest(4) == np.inf
    assert smallest(6) > smallest(12) > smallest(40) > 0
    # of many takes as the normal test has it: 1.645 / sqrt(n)
    assert smallest(40) == pytest.approx(1.645 / 40**0.5, rel=0.15)
