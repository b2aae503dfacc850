"""The render benchmark's bookkeeping: times at equal error, and a plot from the JSON alone."""

import json

import numpy as np
import pytest
from laboratory.light.plots import plot_render
from laboratory.light.render import equal_error, seconds_at
from laboratory.light.render_statistics import bias, compare_blocks, deviation, mean_difference, spread
from PIL import Image


def row(estimator: str, samples: int, seconds: float, error: float) -> dict:
    return {
        "state": "rest", "variant": "llvm_ad_rgb", "estimator": estimator, "samples": samples, "particles": 100,
        "seeds": 8, "seconds": seconds, "cpu_seconds": (3 if estimator == "path" else 2) * seconds, "error": error,
        "error_of_error": 0.01 * error, "flip": None, "mean": [1, 1, 1],
    }  # fmt: skip


ROWS = [
    row("fluence", 4, 0.5, 0.2), row("fluence", 16, 2.0, 0.1),
    row("path", 1, 0.5, 4.0), row("path", 4, 2.0, 2.0), row("path", 16, 8.0, 1.0),
]  # fmt: skip


def test_path_is_extrapolated_from_its_longest_run() -> None:
    found = equal_error(ROWS)
    assert [one["path_seconds"] for one in found] == pytest.approx([8 * 25, 8 * 100])
    assert [one["ratio"] for one in found] == pytest.approx([600, 600])  # of processor seconds


def test_time_at_an_error_follows_the_power_law() -> None:
    assert seconds_at(ROWS, 0.05) == pytest.approx(8.0)
    assert seconds_at(ROWS[:1], 0.05) is None


def test_without_one_of_the_methods_nothing_is_compared() -> None:
    assert equal_error(ROWS[:2]) == []


def test_plot_is_drawn_from_the_file(tmp_path) -> None:
    data = {"kind": "render", "results": [*ROWS, row("path", 1, 9.0, 4.0) | {"variant": "scalar_rgb"}]}
    plot_render(json.loads(json.dumps(data)), tmp_path / "plot.png")
    with Image.open(tmp_path / "plot.png") as plot:
        assert plot.size[0] > 300


TRUTH = np.fromfunction(lambda y, x, c: 2 + np.sin(x / 7) + 0.2 * c + 0.01 * y, (160, 120, 3))


def noisy(count: int, noise: float, seed: int, shift: float = 0.0) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [TRUTH * (1 + shift) + noise * rng.standard_normal(TRUTH.shape) for _ in range(count)]


def test_spread_is_the_noise_over_the_mean() -> None:
    found = spread(noisy(6, 0.3, 0))
    assert found.value == pytest.approx(0.3 / TRUTH[30:-30, 30:-30].mean(), rel=0.02)
    assert found.error < 0.02 * found.value


def test_deviation_holds_what_all_images_share_and_not_the_others_noise() -> None:
    pattern = 0.4 * np.random.default_rng(9).standard_normal(TRUTH.shape)
    ours = [image + pattern for image in noisy(8, 0.3, 0)]
    found = deviation(ours, noisy(8, 1.0, 1))
    assert found.value == pytest.approx(0.5 / TRUTH[30:-30, 30:-30].mean(), rel=0.05)
    assert spread(ours).value < 0.7 * found.value
    assert found.error < 0.05 * found.value


@pytest.mark.parametrize("shift", [0.0, 0.05])
def test_bias_is_found_below_noise_that_is_twenty_times_as_large(shift: float) -> None:
    found = bias(noisy(8, 0.1, 1, shift), noisy(8, 2.0, 2))
    expected = shift * np.sqrt((TRUTH[30:-30, 30:-30] ** 2).mean()) / TRUTH[30:-30, 30:-30].mean()
    assert abs(found.value) < 0.03 if shift == 0 else found.value == pytest.approx(expected, rel=0.2)


def test_mean_radiance_and_its_error() -> None:
    found = mean_difference(noisy(8, 0.5, 3, 0.01), noisy(8, 0.5, 4))
    for one in found:
        assert one.value == pytest.approx(0.01, abs=4 * one.error)
        assert 0 < one.error < 0.002


def test_blocks_that_agree_stay_within_their_bound_and_one_that_does_not_is_counted() -> None:
    ours, theirs = noisy(8, 0.5, 5), noisy(8, 0.5, 6)
    same = compare_blocks(ours, theirs)
    assert same.beyond == 0
    assert same.blocks == (100 // 20) * (60 // 20) * 3
    for image in ours:
        image[70:90, 70:90, 1] *= 1.2
    other = compare_blocks(ours, theirs)
    assert 1 <= other.beyond <= 4
    assert other.worst > other.bound
