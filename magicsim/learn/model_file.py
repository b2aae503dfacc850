"""A fitted model in one file: weights as safetensors, and in the header all that is needed to read frames with it."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from magicsim.errors import ConfigError
from magicsim.learn.samples import Label

HEADER = "magicsim_model"
"""Key of the header's text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelConfig:
    """What a model is, and what it reads."""

    network: str
    labels: tuple[Label, ...]
    input: str
    """`difference` or `frame`."""
    long_side_px: int
    frame_rows: int
    frame_columns: int
    """Size of the frames that it was trained on, before they are reduced [px]."""
    input_mean: tuple[float, ...]
    input_sd: tuple[float, ...]
    """Of each channel of the training inputs."""
    target_mean: tuple[float, ...]
    target_sd: tuple[float, ...]
    """Of each label over the training frames; 0 and 1 of what is no number."""
    recipe_hash: str = ""
    """SHA-256 of the recipe of the training data; empty where there is none."""
    study: str = ""
    """Kind of the study that it comes from."""


def save_model(config: ModelConfig, weights: Mapping[str, Any]) -> bytes:
    """The file's content; equal models give equal bytes.

    Args:
        config: Goes into the header.
        weights: Tensors by name.
    """
    from safetensors.torch import save

    found = {name: tensor.detach().cpu().contiguous() for name, tensor in sorted(weights.items())}
    content: bytes = save(found, {HEADER: json.dumps(asdict(config), sort_keys=True)})
    return content


def read_config(path: Path) -> ModelConfig:
    """What a model file's header says.

    Raises:
        ConfigError: There is no such file, or it is no model of magicsim.
    """
    try:
        return parse_config(path.read_bytes())
    except FileNotFoundError:
        msg = f"model file '{path}' does not exist"
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        msg = f"'{path}' is not a model of magicsim: give a file model.safetensors that a study wrote"
    raise ConfigError(msg)


def parse_config(content: bytes) -> ModelConfig:
    """What the header of a model file's content says.

    Raises:
        ValueError: It is no model; or a `KeyError` or `TypeError`.
    """
    length = int.from_bytes(content[:8], "little")
    if length > len(content):
        msg = "the header is longer than the file"
        raise ValueError(msg)
    values = json.loads(json.loads(content[8 : 8 + length])["__metadata__"][HEADER])
    values["labels"] = tuple(Label(**{**each, "choices": tuple(each["choices"])}) for each in values["labels"])
    for name in ("input_mean", "input_sd", "target_mean", "target_sd"):
        values[name] = tuple(values[name])
    return ModelConfig(**values)
