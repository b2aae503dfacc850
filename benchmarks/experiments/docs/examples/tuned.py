"""What true frames add to a model that learned on fast ones.

python benchmarks/experiments/docs/examples/tuned.py OUT      # of `magicsim study localisation ... --out OUT`; a minute
python benchmarks/experiments/docs/examples/tuned.py OUT --units DATASET --model MODEL                  # three minutes

The first tunes on presses that the study's model learned from, and asks it on those that it did not. The second tunes
on all true frames of the study and those of all units of a dataset but one, asks it on that one, each in turn, and then
writes the model that learned from all of them.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from magicsim_experiments.learn.baselines import constant_answers, mean_score
from magicsim_experiments.learn.model_file import read_model
from magicsim_experiments.learn.networks import open_network
from magicsim_experiments.learn.samples import Samples, Split
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.learn.training import answers_with, train
from magicsim_experiments.study.learned.localisation import read_touches

STOPPING = 6
"""Every so manieth press tells when to stop."""


def joined(one: Samples, other: Samples) -> Samples:
    """Frames of two datasets; units and presses of the second get numbers of their own."""
    names = ("images", "references", "targets", "features", "group", "object_of")
    both = {name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in names}
    numbers = {
        name: np.concatenate([getattr(one, name), getattr(other, name) + start])
        for name, start in (
            ("reference_of", len(one.references)), ("press", 1 + one.press.max()), ("unit", 1 + one.unit.max()),
        )
    }  # fmt: skip
    return replace(one, **both, **numbers)


def tuned(samples: Samples, known: np.ndarray, test: np.ndarray) -> tuple[bytes, np.ndarray]:
    """A model that learned from some presses, and its answers on some frames."""
    some = len(known) // STOPPING
    learned, stopping = (np.flatnonzero(np.isin(samples.press, part)) for part in (known[some:], known[:some]))
    split = Split(train=learned, validation=stopping, test=test)
    found = train(samples, split, settings, config, seed=0, start=content)
    print(f"{len(learned)} frames to learn from")
    assert found.model is not None
    assert found.answers is not None
    return found.model, found.answers


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--units", type=Path)
    parser.add_argument("--model", type=Path)
    given = parser.parse_args()
    fit = given.out / "models" / "learning" / "press-0"
    config, content = read_model(fit / "model.safetensors")
    settings = LearningSettings(learning_rate=3e-4, epochs=40, long_side_px=config.long_side_px)
    samples = read_touches(given.out / "data" / "true-rendering", settings)
    tested = np.unique(pq.read_table(fit / "answers.parquet")["press"].to_numpy())
    parts = [np.flatnonzero(np.isin(samples.press, tested))]
    if given.units:
        own = 1 + samples.unit.max()
        samples = joined(samples, read_touches(given.units, settings))
        parts = [np.flatnonzero(samples.unit == unit) for unit in np.unique(samples.unit) if unit >= own]
    answers = [tuned(samples, np.unique(np.delete(samples.press, part)), part)[1] for part in parts]
    test, rows = np.concatenate(parts), np.arange(len(samples))
    told = {
        "constant": np.concatenate([constant_answers(samples.at(np.delete(rows, each)), len(each)) for each in parts]),
        "as it is": answers_with(open_network(content, config), samples.at(test), config),
        "tuned": np.concatenate(answers),
    }
    for name, found in told.items():
        missed = np.abs(found - samples.targets[test])
        for place, label in enumerate(config.labels):
            score = mean_score(missed[:, place], samples.press[test])
            print(f"{name}: {label.name} {score.value:.3f} ({score.low:.3f} to {score.high:.3f}) {label.unit}")
    print(f"{len(test)} frames of {len(np.unique(samples.press[test]))} presses asked")
    if given.model:
        given.model.write_bytes(tuned(samples, np.unique(samples.press), parts[0])[0])
