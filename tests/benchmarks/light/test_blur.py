import numpy as np
import pytest
from laboratory.light.blur import FREQUENCIES_PER_MM, modulation_transfer
from scipy.special import erf

WIDTH_MM = 0.095
PLACE = (np.arange(240) - 119.5) * WIDTH_MM


def test_sharp_edge_transfers_everything():
    found = modulation_transfer((PLACE > 0).astype(float), WIDTH_MM)
    assert found == pytest.approx(np.ones(len(FREQUENCIES_PER_MM)))


@pytest.mark.parametrize("sigma_mm", [0.2, 0.5])
def test_gaussian_blur_has_a_gaussian_transfer(sigma_mm):
    edge = 0.3 + 0.5 * (1 + erf(PLACE / sigma_mm / np.sqrt(2)))
    expected = np.exp(-2 * (np.pi * sigma_mm * np.array(FREQUENCIES_PER_MM)) ** 2)
    assert modulation_transfer(edge, WIDTH_MM) == pytest.approx(expected, abs=0.03)
