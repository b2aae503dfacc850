"""Trains the network of a touch on noisy true changes, by least squares; a run that was stopped goes on where it was.

Numbers of the examples of each step and of the weights at first follow from the seed, so that the same folder gives the
same network on the same machine and number of threads.
"""

import hashlib
import io
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import AnyArray
from magicsim.distil.examples import Example
from magicsim.distil.network import build_network, find_torch, start_from
from magicsim.emulator.fields import FieldMaker, mirrors_of
from magicsim.emulator.model import TouchModel
from magicsim.folder.ledger import Ledger
from magicsim.scenes.rig import Rig

if TYPE_CHECKING:
    import torch

CHECKPOINT, FIGURES = "training.pt", "training.parquet"
KEPT_MAKERS = 64
"""Sensors whose field makers are kept."""
AVERAGE_STEPS = 500
"""Steps over which the weights are averaged: the noise of the examples shakes each single one."""
GRADIENT = 1.0
"""Longest gradient; what is longer is shortened."""
WARM_STEPS = 100
"""Steps at first in which the rate of learning grows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Training:
    """How the network is trained."""

    steps: int = 12_000
    batch: int = 2
    rate: float = 1e-3
    decay: float = 1e-4
    seed: int = 0
    saved_every: int = 250
    """Steps between checkpoints."""
    start: TouchModel | None = None
    """Whose weights the network begins with; without steps it is measured as it is."""


@dataclass(slots=True, kw_only=True)
class Library:
    """Examples on disk, one touch at a time."""

    paths: Sequence[Path]
    makers: "OrderedDict[str, FieldMaker]" = field(default_factory=OrderedDict)

    def read(self, number: int) -> Example:
        """One example."""
        return Example.read(self.paths[number].read_bytes())

    def __iter__(self) -> Iterator[Example]:
        return (self.read(number) for number in range(len(self.paths)))

    def maker(self, example: Example) -> FieldMaker:
        """What makes its fields, kept for others of the same sensor."""
        scene = example.facts["scene"]
        key = f"{scene['design']} {scene['rig']}"
        if key not in self.makers:
            self.makers[key] = example.maker()
            if len(self.makers) > KEPT_MAKERS:
                self.makers.popitem(last=False)
        return self.makers[key]

    def touch(self, number: int, rng: np.random.Generator) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Fields, gate and change of one touch of an example, drawn at random, perhaps in a mirror."""
        example = self.read(number)
        touch = int(rng.integers(len(example.mask)))
        fields, gate = example.fields(self.maker(example), touch)
        change = example.change[touch, int(rng.integers(example.change.shape[1]))]
        found = fields, gate[None], change.transpose(2, 0, 1).astype(np.float32)
        for mirror in mirrors_of(Rig.model_validate(example.facts["scene"]["rig"])):
            if rng.random() < 0.5:  # noqa: PLR2004 - a coin
                found = mirror.fields(found[0]), mirror.image(found[1]), mirror.image(found[2])
        return found

    def batch(self, size: int, rng: np.random.Generator) -> list[AnyArray]:
        """Touches of as many examples, each array with a first axis over them."""
        chosen = rng.choice(len(self.paths), size, replace=len(self.paths) < size)
        return [np.stack(each) for each in zip(*(self.touch(int(number), rng) for number in chosen), strict=True)]


def train(
    library: Library, settings: Training, ledger: Ledger, progress: Callable[[int, int, float], None]
) -> "torch.nn.Module":
    """The trained network; checkpoint and figures are in the ledger's folder, `progress` is told steps and loss."""
    torch = find_torch()
    channels = library.batch(1, np.random.default_rng(0))[0].shape[1]
    torch.manual_seed(settings.seed)
    network, mean = build_network(channels), build_network(channels)
    if settings.start is not None:
        start_from(network, settings.start)
    optimizer = torch.optim.AdamW(network.parameters(), lr=settings.rate, weight_decay=settings.decay)
    step, losses = 0, []
    mean.load_state_dict(network.state_dict())
    key = _key(library, settings, ledger)
    kept = torch.load(ledger.out / CHECKPOINT, weights_only=True) if (ledger.out / CHECKPOINT).is_file() else {}
    if kept.get("key") == key:
        network.load_state_dict(kept["network"])
        mean.load_state_dict(kept["mean"])
        optimizer.load_state_dict(kept["optimizer"])
        step, losses = kept["step"], kept["losses"]
    while step < settings.steps:
        rng = np.random.default_rng([settings.seed, step])
        fields, gate, change = (
            torch.from_numpy(np.ascontiguousarray(each)) for each in library.batch(settings.batch, rng)
        )
        for group in optimizer.param_groups:
            group["lr"] = settings.rate * min(1, (step + 1) / WARM_STEPS) * (1 - step / settings.steps)
        with torch.autocast("cpu", torch.bfloat16):
            answer = network(fields.contiguous(memory_format=torch.channels_last))
        loss = ((answer.float() * gate - change) ** 2).mean()
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), GRADIENT)
        optimizer.step()
        step += 1
        share = max(1 / step, 1 / AVERAGE_STEPS)
        with torch.no_grad():
            for kept_weight, weight in zip(mean.parameters(), network.parameters(), strict=True):
                kept_weight.lerp_(weight, share)
        losses.append(loss.item())
        if step % settings.saved_every == 0 or step == settings.steps:
            progress(step, settings.steps, float(np.mean(losses[-settings.saved_every :])))
            file, figures = io.BytesIO(), io.BytesIO()
            states = {"network": network, "mean": mean, "optimizer": optimizer}
            now = {name: each.state_dict() for name, each in states.items()}
            now |= {"step": step, "losses": losses, "key": key}
            torch.save(now, file)
            ledger.place(CHECKPOINT, file.getvalue())
            pq.write_table(pa.table({"step": range(1, len(losses) + 1), "loss": losses}), figures)
            ledger.place(FIGURES, figures.getvalue())
    return mean


def _key(library: Library, settings: Training, ledger: Ledger) -> str:
    """Digest of all that a checkpoint follows from: examples, settings and the model begun with."""
    names = [path.relative_to(ledger.out).as_posix() for path in library.paths]
    examples = [(name, ledger.listed(name).sha256) for name in names]
    start = settings.start and hashlib.sha256(settings.start.network).hexdigest()
    return hashlib.sha256(repr((examples, replace(settings, start=None), start)).encode()).hexdigest()
