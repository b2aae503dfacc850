"""From a dataset to a small network that reads place and force of a contact from a picture.

python docs/examples/learn_touch.py touches --figures learn-touch.json --plot learn-touch.png

The picture is the change against the episode's untouched frame, made small; the network is scikit-learn's. What is held
out are whole episodes, never single frames: frames of one episode look alike.
"""

import argparse
import json
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow.parquet as pq
from sklearn.decomposition import PCA
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits

Array = npt.NDArray[np.float64]
PICTURE = (24, 32)
"""Columns and rows that the network sees."""
COLUMNS = ["image", "episode", "is_reference", "contact", "object_position_mm", "force_n"]
STEPS = 150
"""Of training: few, so that the network learns what the frames share rather than each of them."""
SEEDS = range(5)
SHARES = (0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True)
class Touches:
    """Frames in contact, of some episodes."""

    pictures: Array
    """Change against the untouched frame in units of grey levels / 255, shape (frames, pixels x 3)."""
    labels: Array
    """x [mm], y [mm] of the object and normal force [N], shape (frames, 3)."""
    episodes: npt.NDArray[np.int64]
    """Episode of each frame."""


@dataclass(frozen=True)
class Point:
    """One point of the learning curve, mean over seeds with the standard deviation between them."""

    episodes: int
    frames: int
    place_mm: float
    """Root mean square distance between the place that was read and the true one [mm]."""
    place_sd_mm: float
    force_n: float
    """Root mean square error of the normal force [N]."""
    force_sd_n: float


def read(folder: Path, split: str) -> Touches:
    """The frames in contact of one split of a dataset."""
    pictures, labels, episodes = [], [], []
    for shard in sorted((folder / "data").glob(f"{split}-*.parquet")):
        untouched: dict[int, Array] = {}
        for row in pq.read_table(shard, columns=COLUMNS).to_pylist():
            picture = _small(row["image"]["bytes"])
            if row["is_reference"]:
                untouched[row["episode"]] = picture
            elif row["contact"]:
                pictures.append((picture - untouched[row["episode"]]).ravel())
                labels.append([*row["object_position_mm"][:2], row["force_n"][2]])
                episodes.append(row["episode"])
    return Touches(pictures=np.array(pictures), labels=np.array(labels), episodes=np.array(episodes))


def errors(train: Touches, test: Touches, *, seed: int) -> tuple[float, float]:
    """Errors of a network on frames that it was not trained with: place [mm], force [N]."""
    scale = StandardScaler().fit(train.labels)
    parts = min(30, len(train.pictures) - 1)
    network = make_pipeline(
        PCA(parts, random_state=seed, svd_solver="full", whiten=True),
        MLPRegressor(hidden_layer_sizes=(64, 64), alpha=1.0, max_iter=STEPS, solver="lbfgs", random_state=seed),
    )
    with warnings.catch_warnings(), threadpool_limits(1):  # matrices this small are slower on several threads
        warnings.simplefilter("ignore", ConvergenceWarning)  # to stop early is meant
        network.fit(train.pictures, scale.transform(train.labels))
    missed = scale.inverse_transform(network.predict(test.pictures)) - test.labels
    return float(np.sqrt((missed[:, :2] ** 2).sum(1).mean())), float(np.sqrt((missed[:, 2] ** 2).mean()))


def learning_curve(train: Touches, test: Touches) -> list[Point]:
    """Errors on the held-out split after learning from more and more episodes, some chosen anew for each seed."""
    every = np.unique(train.episodes)
    curve = []
    for share in SHARES:
        count, found, frames = max(2, round(share * len(every))), [], 0
        for seed in SEEDS:
            chosen = np.random.default_rng(seed).permutation(every)[:count]
            some = np.isin(train.episodes, chosen)
            frames += int(some.sum())
            found.append(
                errors(Touches(train.pictures[some], train.labels[some], train.episodes[some]), test, seed=seed)
            )
        place, force = np.transpose(found)
        curve.append(
            Point(
                episodes=count, frames=round(frames / len(SEEDS)), place_mm=float(place.mean()),
                place_sd_mm=float(place.std()), force_n=float(force.mean()), force_sd_n=float(force.std()),
            )
        )  # fmt: skip
    return curve


def guess(train: Touches, test: Touches) -> tuple[float, float]:
    """Errors of always answering with the training split's mean: place [mm], force [N]."""
    missed = train.labels.mean(0) - test.labels
    return float(np.sqrt((missed[:, :2] ** 2).sum(1).mean())), float(np.sqrt((missed[:, 2] ** 2).mean()))


def measure(folder: Path) -> dict[str, object]:
    """Everything that the tutorial reports about a dataset."""
    train, test = read(folder, "train"), read(folder, "test")
    place, force = guess(train, test)
    return {
        "train_frames": len(train.labels), "test_frames": len(test.labels),
        "test_episodes": len(np.unique(test.episodes)), "guess_place_mm": place, "guess_force_n": force,
        "curve": [asdict(point) for point in learning_curve(train, test)],
    }  # fmt: skip


def draw(figures: dict, path: Path) -> None:
    """The learning curve."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3), layout="constrained")
    curve = figures["curve"]
    for axes, name, unit in zip(figure.subplots(1, 2), ("place", "force"), ("mm", "N"), strict=True):
        axes.errorbar(
            [point["frames"] for point in curve], [point[f"{name}_{unit.lower()}"] for point in curve],
            [point[f"{name}_sd_{unit.lower()}"] for point in curve], marker="o", label="network",
        )  # fmt: skip
        axes.axhline(figures[f"guess_{name}_{unit.lower()}"], color="0.6", linestyle="--", label="always the mean")
        axes.set(xlabel="frames in contact to learn from", ylabel=f"error of {name} [{unit}]", ylim=(0, None))
        axes.legend(loc="lower left")
    figure.savefig(path, dpi=120)


def _small(png: bytes) -> Array:
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    return cv2.resize(image, PICTURE, interpolation=cv2.INTER_AREA).astype(float) / 255


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--figures", type=Path)
    parser.add_argument("--plot", type=Path)
    asked = parser.parse_args()
    found = measure(asked.dataset)
    print(json.dumps(found, indent=1))
    if asked.figures:
        asked.figures.write_text(json.dumps(found, indent=1) + "\n")
    if asked.plot:
        draw(found, asked.plot)
