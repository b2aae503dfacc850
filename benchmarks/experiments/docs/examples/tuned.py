"""What true frames add to a model that learned on fast ones: columns *on true frames* and *tuned* of the study's page.

python benchmarks/experiments/docs/examples/tuned.py OUT      # of `magicsim study localisation ... --out OUT`; a minute
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from magicsim_experiments.learn.baselines import mean_score
from magicsim_experiments.learn.model_file import read_model
from magicsim_experiments.learn.networks import open_network
from magicsim_experiments.learn.samples import Split
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.learn.training import answers_with, train
from magicsim_experiments.study.learned.localisation import read_touches

STOPPING = 6
"""Every so manieth press tells when to stop."""

if __name__ == "__main__":
    out = Path(sys.argv[1])
    fit = out / "models" / "learning" / "press-0"
    config, content = read_model(fit / "model.safetensors")
    settings = LearningSettings(learning_rate=3e-4, epochs=40, long_side_px=config.long_side_px)
    samples = read_touches(out / "data" / "true-rendering", settings)
    presses, tested = np.unique(samples.press), np.unique(pq.read_table(fit / "answers.parquet")["press"].to_numpy())
    known = presses[~np.isin(presses, tested)]
    some = len(known) // STOPPING
    learned, stopping, test = (
        np.flatnonzero(np.isin(samples.press, part)) for part in (known[some:], known[:some], tested)
    )
    split = Split(train=learned, validation=stopping, test=test)
    tuned = train(samples, split, settings, config, seed=0, start=content)
    told = {"as it is": answers_with(open_network(content, config), samples.at(test), config), "tuned": tuned.answers}
    for name, answers in told.items():
        missed = np.abs(answers - samples.targets[test])
        for place, label in enumerate(config.labels):
            found = mean_score(missed[:, place], samples.press[test])
            print(f"{name}: {label.name} {found.value:.3f} ({found.low:.3f} to {found.high:.3f}) {label.unit}")
