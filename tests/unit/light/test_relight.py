"""Weighted sums of basis images."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.light.relight import relight

BASIS = {name: np.full((2, 3, 3), value, np.float32) for name, value in {"strip0": 1.0, "strip1": 10.0}.items()}


def test_lights_that_are_not_named_keep_their_strength() -> None:
    np.testing.assert_allclose(relight(BASIS, {"strip1": 0.5}), 6.0)
    np.testing.assert_allclose(relight(BASIS, {}), 11.0)


def test_channels_can_be_weighted_apart() -> None:
    np.testing.assert_allclose(relight(BASIS, {"strip0": (0.0, 1.0, 2.0), "strip1": 0.0})[0, 0], [0, 1, 2])


@pytest.mark.parametrize("strengths", [{"strip7": 1.0}, {"strip0": -1.0}])
def test_unknown_lights_and_negative_strengths_are_refused(strengths: dict[str, float]) -> None:
    with pytest.raises(ConfigError):
        relight(BASIS, strengths)
