"""The tutorial from a recipe to a network: on touches that cost nothing, and on simulated ones."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.workers.attempt import WorkerOptions

from .pages import EXAMPLES, load

TINY = [
    "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10", "design.footprint_mm=[12,16]",
    "design.lattice.spacing_mm=2", "design.lattice.cells_across=0", "render.samples=2", "render.particles=2000",
    "render.anchor_samples=2", "render.anchor_particles=2000", "episodes=7",
]  # fmt: skip


@pytest.fixture(scope="module")
def script():
    return load(EXAMPLES / "learn_touch.py")


def spots(folder: Path, split: str, episodes: range) -> None:
    """Rows in which a spot is where the object is, as bright as the force."""
    rows = []
    column, row = np.meshgrid(np.arange(48), np.arange(64))
    for episode in episodes:
        random = np.random.default_rng(episode)
        x, y = random.uniform(-4, 4, 2)
        for step in range(4):
            force = step * random.uniform(0.5, 1)
            spot = np.exp(-((column - 24 - 4 * x) ** 2 + (row - 32 + 4 * y) ** 2) / 60)
            image = np.rint(60 + 60 * force / 3 * spot[..., None] + random.normal(0, 1, (64, 48, 3)))
            rows.append(
                {
                    "image": {"bytes": cv2.imencode(".png", image.astype(np.uint8))[1].tobytes()},
                    "episode": episode, "is_reference": step == 0, "contact": step > 0,
                    "object_position_mm": [x, y, 0.0], "force_n": [0.0, 0.0, force],
                }
            )  # fmt: skip
    (folder / "data").mkdir(exist_ok=True)
    pq.write_table(pa.Table.from_pylist(rows), folder / "data" / f"{split}-00000.parquet")


def test_network_reads_place_and_force_and_learns_from_more_frames(script, tmp_path: Path):
    spots(tmp_path, "train", range(40))
    spots(tmp_path, "test", range(40, 52))
    script.SEEDS = range(2)
    found = script.measure(tmp_path)
    assert (found["train_frames"], found["test_frames"], found["test_episodes"]) == (120, 36, 12)
    first, *_, last = found["curve"]
    assert (first["episodes"], last["episodes"]) == (10, 40)
    assert last["place_mm"] < min(0.6 * first["place_mm"], 0.3 * found["guess_place_mm"])
    assert last["force_n"] < 0.4 * found["guess_force_n"]
    script.draw(found, tmp_path / "curve.png")
    assert cv2.imread(str(tmp_path / "curve.png")).std() > 5


def test_labels_that_mean_nothing_are_not_learnt(script, tmp_path: Path):
    spots(tmp_path, "train", range(20))
    spots(tmp_path, "test", range(20, 30))
    train, test = script.read(tmp_path, "train"), script.read(tmp_path, "test")
    shuffled = replace(train, labels=np.random.default_rng(0).permutation(train.labels))
    place, force = script.errors(shuffled, test, seed=0)
    guess_place, guess_force = script.guess(train, test)
    assert place > 0.8 * guess_place
    assert force > 0.8 * guess_force


@pytest.mark.slow
def test_recipe_of_the_tutorial_ends_in_figures(script, tmp_path: Path):
    recipe = load_recipe(EXAMPLES / "learn-touch.toml", TINY)
    generate_dataset(recipe, tmp_path / "touches", options=WorkerOptions(workers=1))
    train, test = (script.read(tmp_path / "touches", split) for split in ("train", "test"))
    assert not set(train.episodes) & set(test.episodes)
    assert len(train.labels) + len(test.labels) == 7 * 5
    place, force = script.errors(train, test, seed=0)
    assert 0 < place < 8
    assert 0 < force < 10
