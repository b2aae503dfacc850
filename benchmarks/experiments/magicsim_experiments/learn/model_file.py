"""A fitted model in one file: weights as safetensors, and in the header all that is needed to read frames with it."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from magicsim.arrays import Array, Index
from magicsim.config.models import Config, validate
from magicsim.errors import ConfigError
from magicsim_experiments.learn.samples import Label, Samples
from magicsim_experiments.learn.settings import CHANNELS, Input, LearningSettings, LongSidePx, Network
from magicsim_experiments.presets import MODELS

HEADER = "magicsim_model"
"""Key of the header's text."""
Mean = Annotated[float, Field(ge=-1e12, le=1e12)]
Spread = Annotated[float, Field(gt=0, le=1e12)]
SizePx = Annotated[int, Field(ge=1, le=65_535)]


class ModelConfig(Config):
    """What a model is, and what it reads."""

    network: Network
    labels: Annotated[tuple[Label, ...], Field(min_length=1, max_length=1000)]
    input: Input
    """What of frame and untouched reference it reads."""
    long_side_px: LongSidePx
    frame_rows: SizePx
    frame_columns: SizePx
    """Size of the frames that it was trained on, before they are reduced [px]."""
    input_mean: tuple[Mean, ...]
    input_sd: tuple[Spread, ...]
    """Standard deviation of each channel of the training inputs."""
    target_mean: tuple[Mean, ...]
    target_sd: tuple[Spread, ...]
    """Standard deviation of each label over the training frames; 0 and 1 of what is no number."""
    recipe_hash: Annotated[str, Field(max_length=100)] = ""
    """SHA-256 of the recipe of the training data; empty where there is none."""
    study: Annotated[str, Field(max_length=100)] = ""
    """Kind of the study that it comes from."""

    def _problems(self) -> Iterator[str]:
        names = [each.name for each in self.labels]
        if len(set(names)) < len(names):
            yield f"labels.name = {names} is not allowed: names a label twice"
        channels, labels = (CHANNELS[self.input], "channel"), (len(names), "label")
        for field, (count, of) in (
            ("input_mean", channels), ("input_sd", channels), ("target_mean", labels), ("target_sd", labels),
        ):  # fmt: skip
            if len(values := getattr(self, field)) != count:
                yield f"{field} = {list(values)} is not allowed: must have {count} numbers, one a {of}"


def save_model(config: ModelConfig, weights: Mapping[str, Any]) -> bytes:
    """The file's content; equal models give equal bytes."""
    from safetensors.torch import save

    found = {name: tensor.detach().cpu().contiguous() for name, tensor in sorted(weights.items())}
    content: bytes = save(found, {HEADER: json.dumps(config.model_dump(mode="json"), sort_keys=True)})
    return content


def read_model(path: Path) -> tuple[ModelConfig, bytes]:
    """What a model file's header says, and the file's whole content.

    Args:
        path: The file, or the bare name of a model that comes with the experiments.

    Raises:
        ConfigError: There is no such file, it is no model of magicsim, or its header says what is not allowed.
    """
    known = {each.stem: each for each in MODELS.glob("*.safetensors")}
    try:
        content = (path if path.is_file() else known.get(str(path), path)).read_bytes()
    except FileNotFoundError:
        raise ConfigError(f"model file '{path}' does not exist; models by name: {', '.join(sorted(known))}") from None
    except (OSError, ValueError):
        raise ConfigError(_no_model(str(path))) from None
    return parse_config(content, source=str(path)), content


def parse_config(content: bytes, *, source: str = "the model") -> ModelConfig:
    """What the header of a model file's content says.

    Raises:
        ConfigError: It is no model of magicsim, or says what is not allowed.
    """
    end = 8 + int.from_bytes(content[:8], "little")
    try:
        values = {**json.loads(json.loads(content[8:end])["__metadata__"][HEADER])}
    except (ValueError, KeyError, TypeError, RecursionError):
        raise ConfigError(_no_model(source)) from None
    return validate(ModelConfig, values, source=f"model '{source}'")


def _no_model(source: str) -> str:
    return f"'{source}' is not a model of magicsim: give a file model.safetensors that a study wrote"


LEAST_SD = 1e-6
"""Least deviation of inputs in units of the full range, and of labels in their own."""


def model_config(
    samples: Samples, train: Index, settings: LearningSettings, *, network: str, frame_size: tuple[int, int],
    recipe_hash: str = "", study: str = "",
) -> ModelConfig:  # fmt: skip
    """What a model of these frames is, with the scales of the training frames alone.

    The size, rows and columns, is that of the frames before they were reduced.
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
        network=network, labels=samples.labels, input=settings.input, long_side_px=settings.long_side_px,
        frame_rows=frame_size[0], frame_columns=frame_size[1],
        input_mean=tuple(float(each) for each in inputs.mean((0, 1, 2))),
        input_sd=tuple(max(float(each), LEAST_SD) for each in inputs.std((0, 1, 2))), target_mean=tuple(means),
        target_sd=tuple(sds), recipe_hash=recipe_hash, study=study,
    )  # fmt: skip


def output_places(labels: tuple[Label, ...]) -> list[slice]:
    """Which outputs belong to each label: one for a number or a flag, one a value for a choice."""
    widths = [len(label.choices) if label.kind == "choice" else 1 for label in labels]
    ends = [sum(widths[: place + 1]) for place in range(len(widths))]
    return [slice(end - width, end) for end, width in zip(ends, widths, strict=True)]


def answers_of(outputs: npt.NDArray[np.float32], config: ModelConfig) -> Array:
    """Answers in the labels' units: numbers, probabilities of flags, values of choices; shape (n, labels)."""
    answers = np.empty((len(outputs), len(config.labels)))
    for number, (label, places) in enumerate(zip(config.labels, output_places(config.labels), strict=True)):
        found = outputs[:, places].astype(np.float64)
        if label.kind == "choice":
            answers[:, number] = np.array(label.choices)[found.argmax(1)]
        elif label.kind == "flag":
            answers[:, number] = 1 / (1 + np.exp(-np.clip(found[:, 0], -60, 60)))
        else:
            answers[:, number] = found[:, 0] * config.target_sd[number] + config.target_mean[number]
    return answers
