"""The render benchmark's bookkeeping: times at equal error, and a plot from the JSON alone."""

import json

import pytest
from PIL import Image

from magicsim.bench.kinds import draw
from magicsim.bench.light.render import equal_error, seconds_at


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
    file = tmp_path / "bench-render.json"
    file.write_text(json.dumps(data))
    draw(file, tmp_path / "plot.png")
    with Image.open(tmp_path / "plot.png") as plot:
        assert plot.size[0] > 300
