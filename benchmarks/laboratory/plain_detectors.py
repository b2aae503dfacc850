"""The published detectors once more, word by word and in NumPy alone: what `magicsim.detectors` is held against.

Written from the equations (Fan, Li, Zhang, arXiv 2505.24382, Algorithms 1 to 3) and independent of the package: loops
over channels and background references, floating-point convolutions, `np.corrcoef`. The tests compare every option of
the package with it, and `benchmarks/detectors.py` its speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
Array = npt.NDArray[np.float64]

BINOMIAL = {3: (1, 2, 1), 5: (1, 4, 6, 4, 1), 7: (2, 7, 14, 18, 14, 7, 2)}
"""Customary whole-number Gaussians where no sigma is given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlainOptions:
    """The same names and defaults as a detector profile has."""

    tau_e: float = 0.5
    tau_c: float = 0.2
    tau_b: int = 35
    tau_g: float = 0.6
    background_count: int = 3
    grid_blur_px: int = 5
    grid_blur_sigma_px: float = 0.0
    difference_blur_px: int = 0
    polarity: str = "dark"
    similarity: str = "recall"
    grid_reference: str = "presence"
    grey: str = "luma"
    grey_rounding: str = "nearest"
    entropy_bins: int = 256
    constant_channel: str = "zero"


def gaussian_blur(image: Image, size_px: int, sigma_px: float) -> Image:
    """Rows, then columns, with mirrored edges; rounded to 8 bit at the end, halves up."""
    if size_px <= 1:
        return image
    reach = size_px // 2
    if sigma_px == 0 and size_px in BINOMIAL:
        weights = np.array(BINOMIAL[size_px], dtype=float)
    else:
        sigma = sigma_px or 0.15 * size_px + 0.35
        weights = np.exp(-(np.arange(-reach, reach + 1.0) ** 2) / (2 * sigma**2))
    weights /= weights.sum()
    padded = np.pad(image.astype(float), ((reach, reach), (reach, reach), (0, 0)), mode="reflect")
    rows, columns, _ = image.shape
    along = sum(weight * padded[k : k + rows] for k, weight in enumerate(weights))
    both = sum(weight * along[:, k : k + columns] for k, weight in enumerate(weights))
    return np.asarray(np.floor(both + 0.5), np.uint8)


def backgrounds(frames: Sequence[Image], options: PlainOptions) -> list[Image]:
    """B_j: the mean of the j-th run of consecutive frames."""
    blurred = [gaussian_blur(frame, options.difference_blur_px, 0.0) for frame in frames]
    count, total = options.background_count, len(frames)
    runs = [blurred[j * total // count : (j + 1) * total // count] for j in range(count)]
    return [np.floor(np.mean(np.array(run, dtype=float), axis=0) + 0.5).astype(np.uint8) for run in runs]


def binarised(image: Image, options: PlainOptions) -> Array:
    """1 where a blurred pixel shows the grid, else 0."""
    blurred = gaussian_blur(image, options.grid_blur_px, options.grid_blur_sigma_px)
    shown = blurred <= options.tau_b if options.polarity == "dark" else blurred > options.tau_b
    return shown.astype(float)


def grid_reference(frames: Sequence[Image], options: PlainOptions) -> Array:
    """G_ref: the mean of the binarised frames, or what their majority shows."""
    presence = np.asarray(np.sum([binarised(frame, options) for frame in frames], axis=0) / len(frames))
    return (presence > 0.5).astype(float) if options.grid_reference == "majority" else presence


def filtered(frame: Image, references: Sequence[Image], options: PlainOptions) -> Image:
    """F_j = F_(j-1) intersect max(F - B_j, 0), channel by channel."""
    seen = gaussian_blur(frame, options.difference_blur_px, 0.0).astype(int)
    left = seen.copy()
    for background in references:
        for channel in range(3):
            difference = np.maximum(seen[..., channel] - background[..., channel].astype(int), 0)
            left[..., channel] = np.minimum(left[..., channel], difference)
    return left.astype(np.uint8)


def entropy(brightening: Image, options: PlainOptions) -> float:
    """E of the grey image, by counting every bin."""
    weights = np.array([299, 587, 114] if options.grey == "luma" else [1, 1, 1])
    exact = brightening.astype(int) @ weights
    scale = int(weights.sum())
    grey = (2 * exact + scale) // (2 * scale) if options.grey_rounding == "nearest" else exact // scale
    shares = np.bincount((grey * options.entropy_bins // 256).ravel(), minlength=options.entropy_bins) / grey.size
    shares = shares[shares > 0]
    return float(-(shares * np.log2(shares)).sum()) + 0.0


def correlation(brightening: Image, options: PlainOptions) -> float:
    """C: the mean over pairs of channels."""
    values = []
    for one, other in combinations(np.moveaxis(brightening, -1, 0).reshape(3, -1).astype(float), 2):
        if one.std() > 0 and other.std() > 0:
            values.append(float(np.corrcoef(one, other)[0, 1]))
        elif options.constant_channel == "zero":
            values.append(0.0)
    return float(np.mean(values)) if values else 0.0


def similarity(frame: Image, reference: Array, options: PlainOptions) -> float:
    """S: the mean over the channels whose reference shows the grid."""
    shown, values = binarised(frame, options), []
    for channel in range(3):
        now, then = shown[..., channel], reference[..., channel]
        shared = np.minimum(now, then).sum()
        whole = {
            "recall": then.sum(),
            "iou": np.maximum(now, then).sum(),
            "dice": (now.sum() + then.sum()) / 2,
        }[options.similarity]
        if then.sum() > 0:
            values.append(shared / whole)
    return float(np.mean(values))


def verdicts(e: float, c: float, s: float, options: PlainOptions) -> tuple[str, str, str]:
    """Proximity, contact and combined verdict."""
    proximity = "Normal" if e < options.tau_e else "Approaching" if c < options.tau_c else "Noise"
    contact = "Touched" if s < options.tau_g else "Untouched"
    return proximity, contact, "Unknown" if proximity == "Noise" else contact


@dataclass(frozen=True, slots=True, kw_only=True)
class PlainReferences:
    """What Algorithm 1 leaves behind."""

    backgrounds: list[Image]
    grid: Array


def fuse(frames: Sequence[Image], options: PlainOptions) -> PlainReferences:
    """Algorithm 1."""
    return PlainReferences(backgrounds=backgrounds(frames, options), grid=grid_reference(frames, options))


def detect(frame: Image, references: PlainReferences, options: PlainOptions) -> tuple[float, float, float]:
    """Algorithms 2 and 3: E, C and S of one frame."""
    brightening = filtered(frame, references.backgrounds, options)
    return entropy(brightening, options), correlation(brightening, options), similarity(frame, references.grid, options)
