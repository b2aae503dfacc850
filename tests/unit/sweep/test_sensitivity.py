import numpy as np
import pytest

from magicsim.sweep.sensitivity import ApproachCurve, contact_sensitivity, noticed_from, proximity_range

DEPTHS = np.array([0.1, 0.2, 0.3, 1.0])


def curve(entropy: np.ndarray, correlation: float = 0.1) -> ApproachCurve:
    random = np.random.default_rng(0)
    return ApproachCurve(
        gaps_mm=np.array([20.0, 10.0, 5.0]), entropy=entropy, correlation=np.full(entropy.shape, correlation),
        clear_entropy=random.uniform(0.3, 0.4, 200), tau_c=0.5,
    )  # fmt: skip


def test_sensitivity_is_the_slope_of_a_light_touch_alone():
    random = np.random.default_rng(1)
    similarity = (1 - 0.4 * DEPTHS)[:, None] + random.normal(0, 0.002, (4, 24))
    similarity[3] = 0.0  # deeper than a light touch: must not count
    found = contact_sensitivity(DEPTHS, DEPTHS, similarity, seed=1)
    assert found.value == pytest.approx(0.4, abs=0.01)
    assert found.low < 0.4 < found.high
    assert found.high - found.low < 0.03
    against_force = contact_sensitivity(DEPTHS, 2 * DEPTHS, similarity, seed=1)
    assert against_force.value == pytest.approx(found.value / 2)


@pytest.mark.parametrize(
    ("rates", "expected"),
    [
        ((1.0, 1.0, 1.0), 20.0),
        ((0.0, 1.0, 1.0), np.sqrt(200)),
        ((0.0, 0.0, 1.0), np.sqrt(50)),
        ((0.4, 0.5, 1.0), 10.0),
        ((1.0, 1.0, 0.0), 0.0),
        ((1.0, 0.0, 1.0), np.sqrt(50)),
    ],
)
def test_noticed_from_the_outermost_gap_without_a_break(rates: tuple[float, ...], expected: float):
    assert noticed_from(np.array([20.0, 10.0, 5.0]), np.array(rates)) == pytest.approx(expected)


def test_range_ends_where_entropy_sinks_to_that_of_untouched_frames():
    noticed = np.tile([[0.3], [0.9], [1.5]], (1, 12))
    found = proximity_range(curve(noticed), seed=1)
    assert 10 < found.value < 20
    everywhere = proximity_range(curve(noticed + 1), seed=1)
    assert (everywhere.value, everywhere.high) == (20.0, None)
    assert "at least" in everywhere.note
    assert proximity_range(curve(np.full((3, 12), 0.2)), seed=1).value == 0


def test_brightening_that_is_alike_in_all_channels_is_no_approach():
    assert proximity_range(curve(np.full((3, 12), 2.0), correlation=0.9), seed=1).value == 0
