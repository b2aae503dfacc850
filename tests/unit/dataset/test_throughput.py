"""The benchmark of datasets, on episodes that cost nothing."""

import importlib.util
import sys
from functools import partial
from pathlib import Path

import pytest

from magicsim.dataset.generate import generate_dataset

from .fakes import FAKE, small_recipe

SCRIPT = Path(__file__).resolve().parents[3] / "benchmarks" / "dataset_throughput.py"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch):
    spec = importlib.util.spec_from_file_location("dataset_throughput", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


@pytest.mark.usefixtures("in_process")
def test_benchmark_counts_every_frame_once_over_an_interruption(
    script, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(script, "generate_dataset", partial(generate_dataset, simulator=FAKE))
    recipe = small_recipe("episodes=11")
    script.measure(small_recipe("episodes=4"), tmp_path, 1)
    first = script.summary(recipe, tmp_path, 1)
    script.measure(recipe, tmp_path, 1)
    found = script.summary(recipe, tmp_path, 1)
    assert first.frames < found.frames == sum(1 + each.scene.frame_count for each in script.draw_episodes(recipe))
    assert found.seconds >= first.seconds
    assert found.median_episode_frames_per_second > 0
    assert set(found.median_by_path) == {"flashlight", "touch"}
    assert found.kilobytes_per_frame > 1
    assert 50 < found.megabytes_median <= found.megabytes_peak
    assert 50 < min(found.megabytes_at_quarters) <= max(found.megabytes_at_quarters) <= found.megabytes_peak
