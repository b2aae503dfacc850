"""Frames whose labels are known: a blob on an uneven background, somewhere, of some brightness, or nowhere."""

import numpy as np

from magicsim_experiments.learn.samples import Label, Samples

LABELS = (
    Label(name="x", unit="mm"),
    Label(name="there", kind="flag"),
    Label(name="size", unit="mm", kind="choice", choices=(0.5, 1.0, 2.0)),
)


def made_samples(presses: int = 24, frames: int = 3, *, seed: int = 0, rows: int = 20, columns: int = 16) -> Samples:
    """Blobs at x in [-1, 1] mm of three sizes; every fourth press has none, and then neither x nor size."""
    random = np.random.default_rng(seed)
    place = np.linspace(-1, 1, columns)
    images, targets, press = [], [], []
    background = random.uniform(40, 60, (rows, columns, 3))
    for number in range(presses):
        x, size = random.uniform(-0.8, 0.8), float(random.choice(LABELS[2].choices))
        for _ in range(frames):
            profile = np.exp(-((place - x) ** 2) / (0.02 * size))[None, :, None] * 80 * (number % 4 != 0)
            images.append(background + profile + random.normal(0, 1, background.shape))
            targets.append([x, 1.0, size] if number % 4 else [np.nan, 0.0, np.nan])
            press.append(number)
    count = len(images)
    images = np.array(images, np.float32)
    return Samples(
        images=images, references=background[None].astype(np.float32), reference_of=np.zeros(count, int),
        targets=np.array(targets), labels=LABELS, press=np.array(press), unit=np.array(press) % 3,
        object_of=np.array(press) % 4,
        features=images.mean((1, 3)), group=np.zeros(count, int),
    )  # fmt: skip
