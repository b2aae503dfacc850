import numpy as np
import pytest
from scipy import stats

from magicsim.config.models import validate
from magicsim.errors import ConfigError
from magicsim.sampling.distribution import Distribution, choose

SHARES = (np.arange(2000) + 0.5) / 2000


def values(**fields: object) -> np.ndarray:
    distribution = Distribution(**fields)
    return np.array([distribution.at(share) for share in SHARES])


def test_interval_is_covered_evenly():
    np.testing.assert_allclose(values(low=-2.0, high=6.0), -2 + 8 * SHARES)


def test_logarithmic_interval_is_covered_evenly_in_the_logarithm():
    np.testing.assert_allclose(np.log(values(low=0.1, high=10.0, scale="log")), np.log(0.1) + np.log(100) * SHARES)


def test_normal_distribution_is_that_of_scipy_cut_off_at_three_standard_deviations():
    expected = stats.truncnorm(-3, 3, loc=2.0, scale=0.5).ppf(SHARES)
    np.testing.assert_allclose(values(mean=2.0, sd=0.5), expected, rtol=1e-9)
    assert np.abs(values(mean=2.0, sd=0.5) - 2).max() <= 1.5


def test_choices_come_as_often_as_they_weigh():
    found, counts = np.unique(values(choices=[1.0, 2.0, 4.0], weights=[1.0, 0.0, 3.0]), return_counts=True)
    assert found.tolist() == [1.0, 4.0]
    assert counts.tolist() == [500, 1500]


def test_last_share_below_one_is_the_last_choice():
    assert choose(float(np.nextafter(1, 0)), (0.1,) * 10) == 9


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({}, "needs either low and high, or mean and sd, or choices"),
        ({"low": 1.0}, "needs either"),
        ({"low": 1.0, "high": 2.0, "mean": 1.0, "sd": 1.0}, "needs either"),
        ({"weights": [1.0]}, "needs either"),
        ({"low": 2.0, "high": 1.0}, "low = 2 is not allowed: must be at most high = 1"),
        ({"low": 0.0, "high": 1.0, "scale": "log"}, "low = 0 is not allowed with scale 'log'"),
        ({"choices": [1.0, 2.0], "weights": [1.0]}, r"weights = \[1.0\] is not allowed: must be 2 numbers"),
        ({"choices": [1.0], "weights": [0.0]}, "one of them above 0"),
        ({"mean": 1.0, "sd": -1.0}, "sd = -1.0 is not allowed"),
        ({"low": 0.0, "hihg": 1.0}, "did you mean 'high'"),
    ],
)
def test_what_is_no_distribution_is_refused(fields: dict[str, object], named: str):
    with pytest.raises(ConfigError, match=named):
        validate(Distribution, fields, source="recipe.toml")


@pytest.mark.parametrize(
    "fields",
    [
        {"low": -2.0, "high": 6.0}, {"low": 0.01, "high": 6.0, "scale": "log"}, {"mean": 0.5, "sd": 2.0},
        {"choices": [-2.0, 0.2, 0.7, 6.0], "weights": [1.0, 1.0, 3.0, 1.0]},
    ],
)  # fmt: skip
def test_part_in_a_range_keeps_its_relative_frequencies(fields: dict[str, object]):
    distribution = Distribution(**fields)
    inside = np.array([distribution.at(share, -1.0, 1.0) for share in SHARES])
    whole = np.array([distribution.at(share) for share in (np.arange(20_000) + 0.5) / 20_000])
    expected = np.quantile(whole[(whole >= -1) & (whole <= 1)], SHARES, method="inverted_cdf")
    np.testing.assert_allclose(np.sort(inside), expected, atol=2e-3)
    with pytest.raises(ValueError, match="nothing of it lies in 20 to 30"):
        distribution.at(0.5, 20.0, 30.0)
