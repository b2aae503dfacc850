"""The unit of work of learning: one model, trained for a while in whatever process, with its baselines when it ends."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from magicsim.arrays import Array
from magicsim.dataset.shard import parquet_bytes
from magicsim_experiments.learn.baselines import constant_answers, linear_answers, neighbour_answers
from magicsim_experiments.learn.model_file import model_config, parse_config
from magicsim_experiments.learn.samples import Samples, Split, fold
from magicsim_experiments.learn.settings import LearningSettings

Read = Callable[[Path, LearningSettings], Samples]
"""Importable by name: the samples of a dataset's folder."""
MODEL, LOG, ANSWERS = "model.safetensors", "log.parquet", "answers.parquet"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """One model of several on the same data."""

    name: str
    network: str
    split_by: Literal["press", "unit", "object"] = "press"
    """What is never in two parts."""
    fold: int = 0
    folds: int = 2
    share: float = 1.0
    """Share of the training presses that it learns from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Also:
    """A further dataset that models answer on."""

    name: str
    folder: Path
    same_presses: bool = False
    """Whether its episodes are those of the training data in another light, of which only tested ones are answered."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitTask:
    """One stretch of one fit."""

    fit: Fit
    settings: LearningSettings
    read: Read
    folder: Path
    """Folder of the dataset; every process must see it."""
    frame_size: tuple[int, int]
    recipe_hash: str
    study: str
    seed: int
    also: tuple[Also, ...] = ()
    checkpoint: bytes | None = None
    start: bytes | None = None
    """Model file to begin with, instead of random weights."""
    seconds: float = 60.0
    """Processor time after which the stretch ends with its pass [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOutcome:
    """What a stretch ends with."""

    checkpoint: bytes | None
    """Where to go on; None when the fit has ended."""
    files: dict[str, bytes]
    """Content of its files by name, when it has."""
    share: float
    """Passes so far, of the most there may be."""


def fit_stretch(task: FitTask) -> FitOutcome:
    """Trains a model for a while; when it has ended, answers what it has not seen, beside the baselines."""
    from magicsim_experiments.learn.networks import open_network
    from magicsim_experiments.learn.training import answers_with, train

    samples = _samples(task.read, task.folder, task.settings)
    split = split_of(samples, task.fit, task.settings, seed=task.seed)
    config = parse_config(task.start) if task.start is not None else model_config(
        samples, split.train, task.settings, network=task.fit.network, frame_size=task.frame_size,
        recipe_hash=task.recipe_hash, study=task.study,
    )  # fmt: skip
    done = train(
        samples, split, task.settings, config, seed=task.seed, checkpoint=task.checkpoint, start=task.start,
        seconds=task.seconds,
    )  # fmt: skip
    share = len(done.log) / task.settings.epochs
    if done.model is None or done.answers is None:
        return FitOutcome(checkpoint=done.checkpoint, files={}, share=share)
    known, test = samples.at(split.train), samples.at(split.test)
    files = {
        MODEL: done.model,
        LOG: parquet_bytes(pa.Table.from_pylist([dict(row) for row in done.log])),
        ANSWERS: answers_table(test, done.answers, known, task.settings.input),
    }
    for each in task.also:
        further = _samples(task.read, each.folder, task.settings)
        if each.same_presses:
            further = further.at(np.flatnonzero(np.isin(further.press, np.unique(test.press))))
        if len(further):
            found = answers_with(open_network(done.model, config), further, config)
            files[f"answers-{each.name}.parquet"] = answers_table(further, found, known, task.settings.input)
    return FitOutcome(checkpoint=None, files=files, share=share)


def split_of(samples: Samples, fit: Fit, settings: LearningSettings, *, seed: int) -> Split:
    """Which frames a fit learns from, stops by, and answers."""
    groups = {"press": samples.press, "unit": samples.unit, "object": samples.object_of}[fit.split_by]
    return fold(
        groups, fit.fold, fit.folds, validation_share=settings.validation_share, share=fit.share, seed=seed,
        inner=samples.press,
    )  # fmt: skip


def answers_table(test: Samples, answers: Array, train: Samples, kind: str) -> bytes:
    """Truth and answers of every method on frames, as a Parquet file: columns `truth.LABEL`, `model.LABEL`, ...

    Args:
        answers: Of the model, shape (frames, labels).
    """
    methods = {
        "truth": test.targets, "model": answers, "constant": constant_answers(train, len(test)),
        "neighbour": neighbour_answers(train, test, kind), "linear": linear_answers(train, test),
    }  # fmt: skip
    columns: dict[str, Any] = {"press": test.press, "unit": test.unit, "group": test.group}
    columns["train_frames"] = np.full(len(test), len(train))
    for method, values in methods.items():
        columns |= {f"{method}.{label.name}": values[:, place] for place, label in enumerate(test.labels)}
    return parquet_bytes(pa.table(columns))


def prepare_learning(threads: int) -> None:
    """Bounds OpenCV's threads in a process that trains; PyTorch's are bounded where it trains."""
    import cv2

    cv2.setNumThreads(threads)


@lru_cache(maxsize=4)
def _samples(read: Read, folder: Path, settings: LearningSettings) -> Samples:
    return read(folder, settings)
