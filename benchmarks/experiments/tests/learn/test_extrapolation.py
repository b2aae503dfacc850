import numpy as np
import pytest

from magicsim_experiments.study.learned.answers import CurvePoint, fit_power_law, promise

FRAMES = (50.0, 150.0, 500.0)


def curve(factor: float, exponent: float, *, presses: int = 60, seed: int | None = None) -> list[CurvePoint]:
    """Errors whose mean falls as a power law, each press with an error of its own where there is a seed."""
    random = np.random.default_rng(seed)
    press = np.repeat(np.arange(presses), 3)
    own = np.ones(presses) if seed is None else random.gamma(4, 1 / 4, presses)
    return [(frames, factor * frames**-exponent * own[press], press) for frames in FRAMES]


def test_power_law_of_exact_points_is_found_and_continued():
    factor, exponent = fit_power_law(np.array(FRAMES), 3.0 * np.array(FRAMES) ** -0.4)
    assert (factor, exponent) == (pytest.approx(3.0), pytest.approx(0.4))
    twice, tenfold = promise(curve(3.0, 0.4), [1000.0, 5000.0], seed=1)
    assert twice["error"] == pytest.approx(3.0 * 1000**-0.4)
    assert tenfold["error"] == pytest.approx(3.0 * 5000**-0.4)
    assert (tenfold["low"], tenfold["high"]) == (pytest.approx(tenfold["error"]), pytest.approx(tenfold["error"]))


def test_interval_holds_the_law_as_often_as_it_says():
    found = [promise(curve(3.0, 0.4, seed=seed), [5000.0], seed=seed)[0] for seed in range(100)]
    held = sum(each["low"] <= 3.0 * 5000**-0.4 <= each["high"] for each in found)
    assert 0.86 < held / 100 <= 0.99


def test_floor_makes_the_promise_too_low_and_rising_errors_are_promised_to_rise():
    points = [(frames, errors + 0.3, press) for frames, errors, press in curve(3.0, 0.5)]
    [found] = promise(points, [50_000.0], seed=1)
    assert found["error"] < 0.3 + 3.0 * 50_000**-0.5
    [rising] = promise(curve(0.1, -0.2), [5000.0], seed=1)
    assert (rising["exponent"], rising["error"]) == (pytest.approx(-0.2), pytest.approx(0.1 * 5000**0.2))


def test_one_point_and_errors_of_nothing_promise_nothing():
    points = curve(3.0, 0.4)
    assert promise(points[:1] * 2, [1000.0], seed=1) == []
    assert promise(curve(0.0, 0.4), [1000.0], seed=1) == []
    gone = (900.0, np.full(3, np.nan), np.arange(3))
    assert promise([*points, gone], [1000.0], seed=1) == []
    missing = [(frames, np.append(errors, np.nan), np.append(press, 99)) for frames, errors, press in points]
    assert promise(missing, [1000.0], seed=1)[0]["error"] == pytest.approx(3.0 * 1000**-0.4)
