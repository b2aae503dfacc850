"""From a network's outputs to answers in the labels' units, and the scales that training takes from its frames."""

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index
from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.learn.samples import Samples
from magicsim_experiments.learn.settings import LearningSettings

LEAST_SD = 1e-6
"""Least deviation of inputs in units of the full range, and of labels in their own."""


def model_config(
    samples: Samples, train: Index, settings: LearningSettings, *, network: str, frame_size: tuple[int, int],
    recipe_hash: str = "", study: str = "",
) -> ModelConfig:  # fmt: skip
    """What a model of these frames is, with the scales of the training frames alone.

    Args:
        samples: All frames.
        train: Rows of those that train.
        settings: How to train.
        network: Which network.
        frame_size: Rows and columns of the frames before they were reduced.
        recipe_hash: Of the data.
        study: Kind of the study.
    """
    inputs = samples.at(train).inputs(settings.input)
    targets = samples.targets[train]
    means, sds = [], []
    for place, label in enumerate(samples.labels):
        values = targets[np.isfinite(targets[:, place]), place]
        is_scaled = label.kind == "number" and len(values) > 0
        means.append(float(values.mean()) if is_scaled else 0.0)
        sds.append(max(float(values.std()), LEAST_SD) if is_scaled else 1.0)
    return ModelConfig(
        network=network,
        labels=samples.labels,
        input=settings.input,
        long_side_px=settings.long_side_px,
        frame_rows=frame_size[0],
        frame_columns=frame_size[1],
        input_mean=tuple(float(each) for each in inputs.mean((0, 1, 2))),
        input_sd=tuple(max(float(each), LEAST_SD) for each in inputs.std((0, 1, 2))),
        target_mean=tuple(means),
        target_sd=tuple(sds),
        recipe_hash=recipe_hash,
        study=study,
    )


def answers_of(outputs: npt.NDArray[np.float32], config: ModelConfig) -> Array:
    """Answers in the labels' units: numbers, probabilities of flags, values of choices; shape (n, labels)."""
    answers, place = np.empty((len(outputs), len(config.labels))), 0
    for number, label in enumerate(config.labels):
        if label.kind == "choice":
            width = len(label.choices)
            answers[:, number] = np.array(label.choices)[outputs[:, place : place + width].argmax(1)]
            place += width
            continue
        column = outputs[:, place].astype(np.float64)
        if label.kind == "flag":
            answers[:, number] = 1 / (1 + np.exp(-np.clip(column, -60, 60)))
        else:
            answers[:, number] = column * config.target_sd[number] + config.target_mean[number]
        place += 1
    return answers
