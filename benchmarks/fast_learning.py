"""Whether fast frames serve: `localisation` and `ranging` learned from true and from fast frames, told by true ones.

    python benchmarks/fast_learning.py make localisation DATA     # datasets; goes on where it was stopped
    python benchmarks/fast_learning.py learn localisation DATA --out docs/benchmarks/fast-learning.json

`true` and `fast` are the same states in either tier, `more` is four times as many fast ones, `test` are true frames
of other prints and states; `make` says how long each took. A small network learns from each, three times with
other random numbers. Errors (of place along the face and of force in contact, of place and gap before it) are those of
a frame, the mean of its three networks' errors; intervals of ratios draw whole episodes again. Named before the first
run: a ratio whose interval ends below `MARGIN` counts as equivalent; expected are 1.1 to 1.4 of `fast` and 0.7 to 1.0
of `more`, of touches, and 0.95 to 1.1 of `fast` before contact.
"""

import argparse
import io
import json
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow.parquet as pq
from magicsim_experiments.learn.fitting import Also, Fit, FitTask, fit_stretch
from magicsim_experiments.learn.samples import Samples
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.localisation import read_touches
from magicsim_experiments.study.learned.ranging import read_approaches

from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.judge.measures import ends, resampled
from magicsim.workers.attempt import WorkerOptions

MARGIN = 1.15


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """What is learned."""

    read: Callable[[Path, LearningSettings], Samples]
    errors: dict[str, tuple[str, ...]]
    """Answers whose distance from the truth is one error, by its name."""
    episodes_per_unit: int
    sets: dict[str, tuple[str, int, int]]
    """Tier, episodes and seed of each dataset."""


STUDIES = {
    "localisation": Study(  # four touched frames an episode
        read=read_touches, errors={"place_mm": ("p_x", "p_y"), "force_n": ("f_x", "f_y", "f_z")}, episodes_per_unit=25,
        sets={"test": ("true", 64, 12), "true": ("true", 75, 11), "fast": ("fast", 75, 11), "more": ("fast", 300, 11)},
    ),
    "ranging": Study(  # four frames an episode
        read=read_approaches, errors={"place_mm": ("x", "y"), "gap_mm": ("gap",)}, episodes_per_unit=52,
        sets={"test": ("true", 100, 12), "true": ("true", 125, 11), "fast": ("fast", 125, 11)},
    ),
}  # fmt: skip
SETTINGS = ("labels.displacements=false", "labels.depth_map=false")
LEARNING = LearningSettings(folds=20)
SEEDS, RESAMPLES = (1, 2, 3), 4000
Array = npt.NDArray[np.float64]


def make(study: str, folder: Path) -> None:
    """Every dataset, with the seconds that it took."""
    what = STUDIES[study]
    for name, (tier, episodes, seed) in what.sets.items():
        out, units = folder / name, f"episodes_per_sensor={what.episodes_per_unit}"
        settings = [*SETTINGS, units, f"episodes={episodes}", f"render.tier={tier}", f"seed={seed}"]
        begin = time.perf_counter()
        result = generate_dataset(
            load_recipe(study, settings), out, options=WorkerOptions(workers=2), resume=out.exists()
        )
        found = {"set": name, "frames": result.samples, "seconds": round(time.perf_counter() - begin)}
        print(json.dumps(found), flush=True)


def errors(study: str, folder: Path, name: str, seed: int) -> tuple[str, Array, Array, int]:
    """Errors of a network on the frames of `test`, shape (frames, kinds); their episodes, and how many it learned from.

    Frames without an object, whose place nobody knows, are left out.
    """
    recipe, what = load_recipe(study), STUDIES[study]
    task = FitTask(
        fit=Fit(name="press", network="small", folds=LEARNING.folds), settings=LEARNING, read=what.read,
        folder=folder / name, frame_size=(recipe.rig.camera.rows, recipe.rig.camera.columns),
        recipe_hash="", study=study, seed=seed, also=(Also(name="test", folder=folder / "test"),),
        seconds=float("inf"),
    )  # fmt: skip
    table: Any = pq.read_table(io.BytesIO(fit_stretch(task).files["answers-test.parquet"]))
    off = {
        name: np.sqrt(sum((np.array(table[f"model.{key}"]) - np.array(table[f"truth.{key}"], float)) ** 2
                          for key in keys)) for name, keys in what.errors.items()
    }  # fmt: skip
    found = np.column_stack(list(off.values()))
    known = np.isfinite(found).all(1)
    return name, found[known], np.array(table["press"])[known], int(table["train_frames"][0].as_py())


def learn(study: str, folder: Path) -> dict[str, Any]:
    """Errors of all sets, and their ratios to those of `true`."""
    what = STUDIES[study]
    sets = [name for name in what.sets if name != "test"]
    jobs = [(study, folder, name, seed) for name in sets for seed in SEEDS]
    with ProcessPoolExecutor(2) as pool:
        done = list(pool.map(errors, *zip(*jobs, strict=True)))
    press = done[0][2]
    _, member = np.unique(press, return_inverse=True)
    mean = {name: np.mean([each[1] for each in done if each[0] == name], 0) for name in sets}
    sums = {name: np.stack([np.bincount(member, column) for column in found.T], 1) for name, found in mean.items()}
    drawn = resampled(member.max() + 1, RESAMPLES, np.random.default_rng(0))
    found: dict[str, Any] = {"margin": MARGIN, "test_frames": len(press), "test_episodes": int(member.max() + 1)}
    for name, each in mean.items():
        ratios = sums[name][drawn].sum(1) / sums["true"][drawn].sum(1)
        found[name] = {
            "train_frames": next(one[3] for one in done if one[0] == name),
            **{label: {
                "error": round(float(each[:, place].mean()), 4),
                "of_single_networks": [round(float(one[1][:, place].mean()), 4) for one in done if one[0] == name],
                "of_true": round(float(each[:, place].mean() / mean["true"][:, place].mean()), 3),
                "interval": np.round(ends(ratios[:, place]), 3).tolist(),
            } for place, label in enumerate(what.errors)},
        }  # fmt: skip
    return found


def main() -> None:
    """Makes, or learns from what is made."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("make", "learn"))
    parser.add_argument("study", choices=tuple(STUDIES))
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    if chosen.what == "make":
        make(chosen.study, chosen.data)
        return
    found = learn(chosen.study, chosen.data)
    print(json.dumps(found, indent=1))
    if chosen.out is not None:
        chosen.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
