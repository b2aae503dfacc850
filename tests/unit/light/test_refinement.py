"""The error that a mean of images claims is the one it has."""

import numpy as np
import pytest

from magicsim.light.plain_renderer import LEAST_PASSES, Refinement, central

TRUTH = np.fromfunction(lambda y, x, c: 1 + 0.5 * np.sin(x / 5) + 0.1 * c + 0.01 * y, (60, 48, 3))


@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_estimate_is_the_actual_error(noise: float) -> None:
    rng, refinement = np.random.default_rng(1), Refinement()
    while not refinement.is_within(0.02):
        refinement.add((TRUTH * (1 + noise * rng.standard_normal(TRUTH.shape))).astype(np.float32))
    actual = np.sqrt((central(refinement.image - TRUTH) ** 2).mean()) / central(TRUTH).mean()
    assert refinement.relative_error == pytest.approx(actual, rel=0.15)
    assert refinement.passes >= LEAST_PASSES


def test_few_images_claim_nothing() -> None:
    refinement = Refinement()
    for _ in range(LEAST_PASSES - 1):
        refinement.add(TRUTH.astype(np.float32))
    assert refinement.relative_error == np.inf


def test_edges_do_not_count() -> None:
    assert central(np.zeros((320, 240, 3))).shape == (260, 180, 3)
    assert central(np.zeros((12, 16, 3))).shape == (6, 8, 3)
