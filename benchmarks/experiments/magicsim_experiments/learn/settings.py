"""How models are trained: the table `[learning]` of a study's file."""

import importlib.util
from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config
from magicsim.errors import ConfigError

PACKAGES = ("torch", "safetensors")
"""Packages of the extra `learn`."""


def need_packages(names: Iterable[str], what: str) -> None:
    """Refuses (`ConfigError`) to go on without packages; one that no extra brings is installed by its own name."""
    for name in names:
        if importlib.util.find_spec(name) is None:
            source = "'magicsim-experiments[learn]'" if name in PACKAGES else name
            raise ConfigError(f"{what} needs the package {name}: pip install {source}")


Network = Literal["small", "resnet18"]
Input = Literal["difference", "both", "frame"]
CHANNELS: dict[Input, int] = {"difference": 3, "both": 6, "frame": 3}
"""Channels that a network reads."""
LongSidePx = Annotated[int, Field(ge=0, le=4096)]


class LearningSettings(Config):
    """Training of one or more networks on the same data."""

    networks: Annotated[tuple[Network, ...], Field(min_length=1)] = ("small",)
    """The first one gives the results; others are trained for the first fold, to compare."""
    long_side_px: LongSidePx = 80
    """Frames are reduced so that their longer side has so many pixels; 0 keeps the full size."""
    input: Input = "difference"
    """Frame minus the untouched reference of the unit, that and the reference, or the frame as it is."""
    epochs: Annotated[int, Field(ge=1, le=10_000)] = 60
    """Most passes over the training frames."""
    patience: Annotated[int, Field(ge=1, le=10_000)] = 15
    """Passes without a smaller validation loss after which training ends."""
    batch: Annotated[int, Field(ge=2, le=4096)] = 16
    """Frames of a step."""
    learning_rate: Annotated[float, Field(gt=0, le=1)] = 1e-3
    """Learning rate of AdamW at the start; falls as a cosine to a hundredth at the last pass."""
    weight_decay: Annotated[float, Field(ge=0, le=1)] = 1e-3
    """Weight decay of AdamW."""
    folds: Annotated[int, Field(ge=2, le=20)] = 4
    """Parts of the groups, each of which is the test of a model trained on the others."""
    folds_used: Annotated[int, Field(ge=1, le=20)] = 4
    """How many of these models are trained."""
    validation_share: Annotated[float, Field(gt=0, lt=0.9)] = 0.15
    """Share of the groups left for training that tell when to stop."""
    curve: Annotated[tuple[Annotated[float, Field(gt=0, lt=1)], ...], Field(max_length=8)] = (0.25, 0.5)
    """Shares of the training groups that further models learn from, for the learning curve."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """`auto` takes an NVIDIA GPU where there is one. Weights differ in their last digits between devices."""
