import pytest

from magicsim.config.ranges import check_number
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
