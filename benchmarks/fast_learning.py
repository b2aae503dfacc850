"""Whether fast frames serve: `localisation` learned from true and from fast frames, and told by true ones.

    python benchmarks/fast_learning.py make DATA     # four datasets; goes on where it was stopped
    python benchmarks/fast_learning.py learn DATA --out docs/benchmarks/fast-learning.json

`true` and `fast` are the same touches in either tier, `more` is four times as many fast ones, `test` are true frames of
other prints and presses; `make` says how long each took. A small network learns from each, three times with
other random numbers. The error of place (along the face) and of force is that of a frame, the mean of its three
networks' errors; intervals of ratios draw whole presses again. Named before the first run: a ratio whose interval ends
below `MARGIN` counts as equivalent; expected are 1.1 to 1.4 of `fast`, 0.7 to 1.0 of `more`.
"""

import argparse
import io
import json
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow.parquet as pq
from magicsim_experiments.learn.fitting import Also, Fit, FitTask, fit_stretch
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.localisation import read_touches

from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.judge.measures import ends, resampled
from magicsim.workers.attempt import WorkerOptions

MARGIN = 1.15
SETS = {"test": ("true", 64, 12), "true": ("true", 75, 11), "fast": ("fast", 75, 11), "more": ("fast", 300, 11)}
"""Tier, episodes of four touched frames, and seed of each."""
SETTINGS = ("episodes_per_sensor=25", "labels.displacements=false", "labels.depth_map=false")
LEARNING = LearningSettings(folds=20)
SEEDS, RESAMPLES = (1, 2, 3), 4000
Array = npt.NDArray[np.float64]


def make(folder: Path) -> None:
    """Every dataset, with the seconds that it took."""
    for name, (tier, episodes, seed) in SETS.items():
        out = folder / name
        settings = [*SETTINGS, f"episodes={episodes}", f"render.tier={tier}", f"seed={seed}"]
        begin = time.perf_counter()
        result = generate_dataset(
            load_recipe("localisation", settings), out, options=WorkerOptions(workers=2), resume=out.exists()
        )
        print(
            json.dumps({"set": name, "frames": result.samples, "seconds": round(time.perf_counter() - begin)}),
            flush=True,
        )


def errors(folder: Path, name: str, seed: int) -> tuple[str, Array, Array, int]:
    """Errors of a network on the frames of `test`, shape (frames, 2): place [mm], force [N]; their presses."""
    recipe = load_recipe("localisation")
    task = FitTask(
        fit=Fit(name="press", network="small", folds=LEARNING.folds), settings=LEARNING, read=read_touches,
        folder=folder / name, frame_size=(recipe.rig.camera.rows, recipe.rig.camera.columns), recipe_hash="",
        study="localisation", seed=seed, also=(Also(name="test", folder=folder / "test"),), seconds=float("inf"),
    )  # fmt: skip
    table: Any = pq.read_table(io.BytesIO(fit_stretch(task).files["answers-test.parquet"]))
    off = {key: np.array(table[f"model.{key}"]) - np.array(table[f"truth.{key}"])
           for key in ("p_x", "p_y", "f_x", "f_y", "f_z")}  # fmt: skip
    place, force = (np.sqrt(sum(off[key] ** 2 for key in off if key[0] == kind)) for kind in "pf")
    return name, np.column_stack([place, force]), np.array(table["press"]), int(table["train_frames"][0].as_py())


def learn(folder: Path) -> dict[str, Any]:
    """Errors of all sets, and their ratios to those of `true`."""
    jobs = [(folder, name, seed) for name in SETS if name != "test" for seed in SEEDS]
    with ProcessPoolExecutor(2) as pool:
        done = list(pool.map(errors, *zip(*jobs, strict=True)))
    press = done[0][2]
    _, member = np.unique(press, return_inverse=True)
    mean = {name: np.mean([each[1] for each in done if each[0] == name], 0) for name in SETS if name != "test"}
    sums = {name: np.stack([np.bincount(member, column) for column in found.T], 1) for name, found in mean.items()}
    drawn = resampled(member.max() + 1, RESAMPLES, np.random.default_rng(0))
    found: dict[str, Any] = {"margin": MARGIN, "test_frames": len(press), "test_presses": int(member.max() + 1)}
    for name, each in mean.items():
        ratios = sums[name][drawn].sum(1) / sums["true"][drawn].sum(1)
        found[name] = {
            "train_frames": next(one[3] for one in done if one[0] == name),
            **{label: {
                "error": round(float(each[:, place].mean()), 4),
                "of_single_networks": [round(float(one[1][:, place].mean()), 4) for one in done if one[0] == name],
                "of_true": round(float(each[:, place].mean() / mean["true"][:, place].mean()), 3),
                "interval": np.round(ends(ratios[:, place]), 3).tolist(),
            } for place, label in enumerate(("place_mm", "force_n"))},
        }  # fmt: skip
    return found


def main() -> None:
    """Makes, or learns from what is made."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("make", "learn"))
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    if chosen.what == "make":
        make(chosen.data)
        return
    found = learn(chosen.data)
    print(json.dumps(found, indent=1))
    if chosen.out is not None:
        chosen.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
