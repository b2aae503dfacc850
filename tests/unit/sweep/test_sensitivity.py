import numpy as np
import pytest

from magicsim.sweep.detection import ApproachCurve, contact_sensitivity, noticed_from, proximity_range


def curves(*renderings: np.ndarray, correlation: float = 0.1) -> list[ApproachCurve]:
    """One for each rendering's entropy, shape (gaps, draws)."""
    random = np.random.default_rng(0)
    return [
        ApproachCurve(
            gaps_mm=np.array([20.0, 10.0, 5.0]), entropy=entropy, correlation=np.full(entropy.shape, correlation),
            clear_entropy=random.uniform(0.3, 0.4, 200), tau_c=0.5,
        )
        for entropy in renderings
    ]  # fmt: skip


def test_sensitivity_is_the_mean_loss_over_places_and_its_interval_is_theirs():
    random = np.random.default_rng(1)
    light = 0.97 + random.normal(0, 0.001, (1, 12))
    firm = light - 0.2 * (0.4 + random.normal(0, 0.05, (1, 12)))
    found = contact_sensitivity(light, firm, step=0.2, seed=1)
    assert found.value == pytest.approx(0.4, abs=0.03)
    assert found.low < found.value < found.high
    assert 0.02 < found.high - found.low < 0.12
    against_force = contact_sensitivity(light, firm, step=0.4, seed=1)
    assert against_force.value == pytest.approx(found.value / 2)


def test_renderings_that_disagree_widen_the_interval_of_the_sensitivity():
    light = np.full((3, 12), 0.97)
    firm = light - 0.2 * np.array([[0.3], [0.4], [0.5]])
    found = contact_sensitivity(light, firm, step=0.2, seed=1)
    assert (found.low, found.value, found.high) == pytest.approx((0.3, 0.4, 0.5))


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
    found = proximity_range(curves(noticed), seed=1)
    assert 10 < found.value < 20
    everywhere = proximity_range(curves(noticed + 1), seed=1)
    assert (everywhere.value, everywhere.high) == (20.0, None)
    assert "at least" in everywhere.note
    assert proximity_range(curves(np.full((3, 12), 0.2)), seed=1).value == 0


def test_brightening_that_is_alike_in_all_channels_is_no_approach():
    assert proximity_range(curves(np.full((3, 12), 2.0), correlation=0.9), seed=1).value == 0


def test_interval_of_the_range_holds_what_renderings_disagree_about():
    noticed, missed = np.tile([[0.2], [1.5], [1.5]], (1, 12)), np.tile([[0.2], [0.2], [1.5]], (1, 12))
    far, close = np.sqrt(20 * 10), np.sqrt(10 * 5)
    found = proximity_range(curves(noticed, missed, noticed), seed=1)
    assert found.value == pytest.approx((2 * far + close) / 3)
    assert (found.low, found.high) == pytest.approx((close, far))
    alike = proximity_range(curves(*[noticed] * 3), seed=1)
    assert (alike.low, alike.high) == pytest.approx((far, far))
