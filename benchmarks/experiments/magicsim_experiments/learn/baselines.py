"""Answers that a learned model has to beat: a constant, the nearest neighbour, a linear fit of geometric features."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.stats import mode

from magicsim.arrays import Array, Index
from magicsim.judge.measures import ends, resampled
from magicsim_experiments.learn.samples import Images, Label, Samples

RESAMPLES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """A mean over frames, with what it may be for other presses."""

    value: float
    """Mean; NaN of no frames."""
    sd: float
    low: float
    high: float
    """Ends of the 95 % percentile interval of the mean, presses drawn again with replacement (Field and Welsh 2007)."""
    frames: int
    presses: int


def mean_score(values: Array, press: Index, *, seed: int = 0) -> Score:
    """Mean of a quantity of frames, such as an absolute error.

    Args:
        values: Shape (n,); NaN where it does not exist.
        press: Group of each frame that is drawn as a whole, shape (n,).
    """
    there = np.isfinite(values)
    values, press = values[there], press[there]
    if not len(values):
        nan = float("nan")
        return Score(value=nan, sd=nan, low=nan, high=nan, frames=0, presses=0)
    _, member = np.unique(press, return_inverse=True)
    sums, counts = np.bincount(member, values), np.bincount(member)
    random = np.random.default_rng([seed, len(values)])
    drawn = resampled(len(sums), RESAMPLES, random)
    means = sums[drawn].sum(1) / counts[drawn].sum(1)
    low, high = ends(means)
    return Score(
        value=float(values.mean()), sd=float(values.std()), low=low, high=high,
        frames=len(values), presses=len(sums),
    )  # fmt: skip


PENALTY = 1e-3
"""Penalty of the ridge, in units of the mean square of the standardised features."""
NEIGHBOUR_PX = 20
"""Longer side of the frames among which the nearest is looked for [px]."""


def constant_answers(train: Samples, count: int) -> Array:
    """The constant with the smallest mean absolute error on the training frames, for so many frames.

    The median of a number, the more frequent value of a flag or a choice; shape (count, labels).
    """
    found = [_middle(label, train.targets[:, place]) for place, label in enumerate(train.labels)]
    return np.tile(np.array(found), (count, 1))


def neighbour_answers(train: Samples, test: Samples, kind: str) -> Array:
    """Labels of the nearest training frame, by coarse inputs, of those that have each label; shape (frames, labels)."""
    known, asked = _coarse(train.inputs(kind)), _coarse(test.inputs(kind))
    squared = (asked**2).sum(1)[:, None] - 2 * asked @ known.T + (known**2).sum(1)[None]
    answers = np.full((len(test), len(train.labels)), np.nan)
    for place in range(len(train.labels)):
        there = np.flatnonzero(np.isfinite(train.targets[:, place]))
        if len(there):
            answers[:, place] = train.targets[there[squared[:, there].argmin(1)], place]
    return answers


def linear_answers(train: Samples, test: Samples) -> Array:
    """A ridge regression of the labels on the geometric features, shape (test frames, labels).

    Each label is fitted to the frames that have it; a flag or a choice is answered by its nearest value.
    """
    centre, spread = train.features.mean(0), np.maximum(train.features.std(0), 1e-12)
    known, asked = (train.features - centre) / spread, (test.features - centre) / spread
    known, asked = (np.column_stack([np.ones(len(each)), each]) for each in (known, asked))
    answers = np.full((len(asked), len(train.labels)), np.nan)
    for place, label in enumerate(train.labels):
        there = np.isfinite(train.targets[:, place])
        if not there.any():
            continue
        rows, targets = known[there], train.targets[there, place]
        weights = np.diag([0.0, *np.full(rows.shape[1] - 1, PENALTY * len(rows))])
        found = asked @ np.linalg.solve(rows.T @ rows + weights, rows.T @ targets)
        answers[:, place] = _nearest_choice(label, found)
    return answers


def change_features(images: Images, reference: Images) -> Array:
    """Where and how much frames differ from the untouched sensor, shape (n, 12).

    Centroid of the squared change along columns and rows, its spread along both, by channel; shares of the image.

    Args:
        images: Shape (n, rows, columns, 3).
        reference: Shape (rows, columns, 3).
    """
    change = np.square(images.astype(float) - reference)
    total = np.maximum(change.sum((1, 2)), 1e-12)
    parts = []
    for axis in (2, 1):
        place = (np.arange(change.shape[axis]) + 0.5) / change.shape[axis] - 0.5
        profile = change.sum(3 - axis) / total[:, None]
        centre = np.einsum("nkc,k->nc", profile, place)
        spread = np.einsum("nkc,k->nc", profile, place**2) - centre**2
        parts += [centre, np.sqrt(np.maximum(spread, 0))]
    return np.concatenate(parts, 1)


def lean_features(images: Images, reference: Images) -> Array:
    """How the change leans in the image, shape (n, 6): cosine and sine of twice its main axis' angle, by channel.

    The angle is that of the largest second moment of the squared change, from the rows' direction; both are weighted
    with how elongated the change is, 0 of a round one. Images are as in `change_features`.
    """
    change = np.square(images.astype(float) - reference)
    change /= np.maximum(change.sum((1, 2), keepdims=True), 1e-12)
    rows, columns = (np.arange(count) + 0.5 - count / 2 for count in change.shape[1:3])
    down, right = (np.einsum("nrck,r->nk", change, rows), np.einsum("nrck,c->nk", change, columns))
    tall = np.einsum("nrck,r->nk", change, rows**2) - down**2
    wide = np.einsum("nrck,c->nk", change, columns**2) - right**2
    lean = np.einsum("nrck,r,c->nk", change, rows, columns) - down * right
    size = np.maximum(tall + wide, 1e-12)
    return np.concatenate([(tall - wide) / size, 2 * lean / size], 1)


def _middle(label: Label, values: Array) -> float:
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan")
    return float(np.median(values) if label.kind == "number" else mode(values).mode)


def _nearest_choice(label: Label, values: Array) -> Array:
    choices = {"number": (), "flag": (0.0, 1.0), "choice": label.choices}[label.kind]
    if not choices:
        return values
    return np.asarray(np.array(choices)[np.abs(values[:, None] - np.array(choices)).argmin(1)])


def _coarse(inputs: Images) -> Images:
    """Inputs reduced and made flat, shape (n, values)."""
    scale = min(1.0, NEIGHBOUR_PX / max(inputs.shape[1:3]))
    size = (max(1, round(inputs.shape[2] * scale)), max(1, round(inputs.shape[1] * scale)))
    parts = np.split(inputs, inputs.shape[-1] // 3, -1)  # OpenCV resizes four channels at most
    small = [[cv2.resize(each, size, interpolation=cv2.INTER_AREA).ravel() for each in part] for part in parts]
    return np.hstack(small)
