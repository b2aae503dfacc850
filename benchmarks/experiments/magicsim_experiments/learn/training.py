"""Training of one network: seeded, in stretches that end with a pass over the frames, so that it resumes exactly."""

import copy
import io
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from magicsim.arrays import Array, Index
from magicsim_experiments.learn.model_file import ModelConfig, answers_of, output_places, save_model
from magicsim_experiments.learn.networks import load_weights, network_of
from magicsim_experiments.learn.samples import Label, Samples, Split
from magicsim_experiments.learn.settings import LearningSettings


def label_loss(outputs: torch.Tensor, targets: torch.Tensor, labels: tuple[Label, ...]) -> torch.Tensor:
    """Sum over labels of the mean loss of the frames that have them.

    Smooth absolute errors of standardised numbers, cross entropies of flags and choices.

    Args:
        outputs: Shape (n, outputs), see `output_places`.
        targets: Shape (n, labels), see `scaled_targets`; NaN where there is none.
    """
    total = outputs.sum() * 0
    for place, (label, columns) in enumerate(zip(labels, output_places(labels), strict=True)):
        there = torch.isfinite(targets[:, place])
        if not bool(there.any()):
            continue
        found, wanted = outputs[there, columns], targets[there, place]
        if label.kind == "number":
            total = total + functional.smooth_l1_loss(found[:, 0], wanted)
        elif label.kind == "flag":
            total = total + functional.binary_cross_entropy_with_logits(found[:, 0], wanted)
        else:
            total = total + functional.cross_entropy(found, wanted.long())
    return total


def scaled_targets(samples: Samples, config: ModelConfig) -> npt.NDArray[np.float32]:
    """Targets as the loss takes them, shape (n, labels): numbers standardised, choices by their place."""
    found = (samples.targets - np.array(config.target_mean)) / np.array(config.target_sd)
    for place, label in enumerate(samples.labels):
        if label.kind == "choice":
            values = samples.targets[:, place]
            found[:, place] = np.where(np.isfinite(values), np.searchsorted(label.choices, values), np.nan)
    return np.asarray(found, np.float32)


LAST_RATE = 0.01
"""Learning rate of the last pass, in units of the first one's."""
BATCH = 64
"""Frames that are answered on at once."""
LogRow = dict[str, float | int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """What a stretch of training ends with."""

    checkpoint: bytes | None
    """Where to go on; None when training has ended."""
    model: bytes | None
    """The model's file, when it has."""
    answers: Array | None
    """Answers of the model on the test frames, shape (test frames, labels)."""
    log: tuple[LogRow, ...]
    """One row a pass so far: `epoch`, `train_loss`, `validation_loss`, `learning_rate`."""


def train(
    samples: Samples, split: Split, settings: LearningSettings, config: ModelConfig, *, seed: int,
    checkpoint: bytes | None = None, start: bytes | None = None, seconds: float = math.inf,
) -> Trained:  # fmt: skip
    """Trains until it ends, or for some time.

    Args:
        config: What the model is, see `model_config`.
        checkpoint: Where an earlier stretch ended.
        start: Weights to begin with instead of random ones: a model file's content.
        seconds: Processor time after which the stretch ends with the pass that is under way [s].

    Returns:
        On a CPU the same model, bit for bit, in however many stretches it is trained.
    """
    begun = time.process_time()
    is_gpu = settings.device == "cuda" or (settings.device == "auto" and torch.cuda.is_available())
    device = torch.device("cuda" if is_gpu else "cpu")
    torch.use_deterministic_algorithms(True, warn_only=is_gpu)  # not every sum has one on a GPU
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    network = network_of(config)
    if start is not None:
        load_weights(network, start)
    network.to(device)
    optimizer = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )  # fmt: skip
    state: dict[str, Any] = {"epoch": 0, "stale": 0, "best_loss": math.inf, "log": []}
    best = copy.deepcopy(network.state_dict())
    if checkpoint is not None:
        found = torch.load(io.BytesIO(checkpoint), weights_only=True, map_location=device)
        network.load_state_dict(found["network"])
        optimizer.load_state_dict(found["optimizer"])
        best, state = found["best"], found["state"]
    images = torch.from_numpy(_normalised(samples, config))
    targets = torch.from_numpy(scaled_targets(samples, config))
    while state["epoch"] < settings.epochs and state["stale"] < settings.patience:
        epoch = state["epoch"]
        share = epoch / max(1, settings.epochs - 1)
        rate = settings.learning_rate * (LAST_RATE + (1 - LAST_RATE) * (1 + math.cos(math.pi * share)) / 2)
        for group in optimizer.param_groups:
            group["lr"] = rate
        order = np.random.default_rng([seed, epoch]).permutation(split.train)
        # Batches of about the same size, none of a single frame: batch normalisation needs two.
        batches = np.array_split(order, max(1, len(order) // settings.batch))
        train_loss = _pass(network, optimizer, images, targets, batches, samples.labels, device)
        validated = torch.from_numpy(_outputs(network, images, split.validation, settings.batch, device))
        loss = float(label_loss(validated, targets[split.validation], samples.labels))
        state["log"].append({
            "epoch": epoch, "train_loss": train_loss, "validation_loss": loss, "learning_rate": rate,
        })  # fmt: skip
        state["epoch"] = epoch + 1
        if loss < state["best_loss"]:
            state["best_loss"], state["stale"] = loss, 0
            best = copy.deepcopy(network.state_dict())
        else:
            state["stale"] += 1
        if time.process_time() - begun > seconds and state["epoch"] < settings.epochs:
            buffer = io.BytesIO()
            torch.save(
                {"network": network.state_dict(), "optimizer": optimizer.state_dict(), "best": best, "state": state},
                buffer,
            )
            return Trained(checkpoint=buffer.getvalue(), model=None, answers=None, log=tuple(state["log"]))
    network.load_state_dict(best)
    outputs = _outputs(network, images, split.test, settings.batch, device)
    return Trained(
        checkpoint=None, model=save_model(config, best), answers=answers_of(outputs, config), log=tuple(state["log"])
    )


def answers_with(network: torch.nn.Module, samples: Samples, config: ModelConfig) -> Array:
    """Answers of a network, with its weights, on all frames, shape (n, labels)."""
    torch.set_num_threads(1)
    images = torch.from_numpy(_normalised(samples, config))
    return answers_of(_outputs(network, images, np.arange(len(samples)), BATCH, torch.device("cpu")), config)


def _pass(
    network: torch.nn.Module, optimizer: torch.optim.Optimizer, images: torch.Tensor, targets: torch.Tensor,
    batches: list[Index], labels: tuple[Label, ...], device: torch.device,
) -> float:  # fmt: skip
    """One pass over the training frames; returns the mean loss."""
    network.train()
    total, count = 0.0, 0
    for rows in batches:
        loss = label_loss(network(images[rows].to(device)), targets[rows].to(device), labels)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        total, count = total + float(loss.detach()) * len(rows), count + len(rows)
    return total / max(1, count)


def _outputs(
    network: torch.nn.Module, images: torch.Tensor, rows: Index, batch: int, device: torch.device
) -> npt.NDArray[np.float32]:
    network.eval()
    with torch.no_grad():
        places = np.array_split(rows, max(1, -(-len(rows) // batch)))
        parts = [network(images[each].to(device)).cpu() for each in places]
    return np.asarray(torch.cat(parts).numpy())


def _normalised(samples: Samples, config: ModelConfig) -> npt.NDArray[np.float32]:
    mean, sd = (np.array(each, np.float32) for each in (config.input_mean, config.input_sd))
    inputs = (samples.inputs(config.input) - mean) / sd
    return np.ascontiguousarray(inputs.transpose(0, 3, 1, 2), np.float32)
