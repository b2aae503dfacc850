"""The loss of labels of several kinds, of which a frame need not have all."""

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.learn.networks import output_places
from magicsim_experiments.learn.samples import Label, Samples


def label_loss(outputs: torch.Tensor, targets: torch.Tensor, labels: tuple[Label, ...]) -> torch.Tensor:
    """Sum over labels of the mean loss of the frames that have them.

    Smooth absolute errors of standardised numbers, cross entropies of flags and choices.

    Args:
        outputs: Shape (n, outputs), see `output_places`.
        targets: Shape (n, labels), see `scaled_targets`; NaN where there is none.
        labels: Of the columns.
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
