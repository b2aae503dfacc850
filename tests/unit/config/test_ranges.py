import numpy as np
import pytest

from magicsim.config.ranges import check_number, check_vector
from magicsim.errors import ConfigError


@pytest.mark.parametrize(("value", "whole"), [(1, True), (3.0, True), (2.5, False), (1, False)])
def test_number_inside_passes(value: float, whole: bool):
    check_number("frames", value, 1, 3, whole=whole)


@pytest.mark.parametrize(
    ("value", "whole"), [(float("nan"), False), (float("inf"), True), (0, False), (3.1, False), (1.5, True)]
)
def test_number_outside_is_refused_in_the_words_of_configurations(value: float, whole: bool):
    kind = "whole number" if whole else "number"
    message = f"frames = {value:g} is not allowed: must be a {kind} of at least 1 and at most 3"
    with pytest.raises(ConfigError, match=message):
        check_number("frames", value, 1, 3, whole=whole)


@pytest.mark.parametrize("value", ["3", None, True, [1]])
def test_what_is_no_number_is_refused(value: object):
    with pytest.raises(ConfigError, match=r"frames = .* is not allowed: must be a number of at least 1"):
        check_number("frames", value, 1, 3)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (3, "force_n = 3 is not allowed: must be 3 numbers"),
        ("123", "force_n = '123' is not allowed: must be 3 numbers"),
        ((1, 2), r"force_n = \(1, 2\) is not allowed: must be 3 numbers"),
        ((1, 2, "a"), "force_n = 'a' is not allowed: must be a number"),
        ((1, 2, 9), "force_n = 9 is not allowed: must be a number of at least -5 and at most 5"),
    ],
)
def test_what_is_no_row_of_numbers_is_refused(value: object, told: str):
    check_vector("force_n", np.float32([1, 2, 3]), -5, 5)
    with pytest.raises(ConfigError, match=told):
        check_vector("force_n", value, -5, 5)
