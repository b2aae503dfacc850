"""E, C and S of a frame, and those of labelled frames of one untouched sensor for many options at once.

Proximity by E and C, published as the second algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382): an
object seen through side-lit coloured light brightens the channels differently, a flashlight brightens them alike.
Contact by S, its third algorithm: how much of the untouched grid a frame still shows. The paper divides the intersected
area by the reference area (`recall`) and leaves open which side of tau_B is the grid; the other two measures also fall
where a frame shows grid that the reference does not.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import (
    FULL,
    BackgroundReference,
    GridReference,
    blur,
    fuse_background,
    fuse_grid,
    grid_mask,
    levelled,
)
from magicsim.detectors.profile import ConstantChannel, DetectorProfile, Grey, Polarity, Rounding, Similarity
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import ConfigError, FrameError
from magicsim.frame_class import FrameClass

GREY_LEVELS = 256
"""Grey levels of an 8-bit image."""
_LUMA_THOUSANDTHS = (299, 587, 114)
"""Weights of red, green and blue in the luma of ITU-R BT.601, in thousandths."""


def filter_channels(frame: Frame, background: BackgroundReference) -> Frame:
    """Brightening against every background reference in grey levels, per channel: F_filtered = max(F - max_j B_j, 0).

    It equals the published loop F_j = F_(j-1) intersect max(F - B_j, 0), j = 1..M, with F_0 = F and the pixelwise
    minimum as the intersection of grey images. All have shape (rows, columns, 3).
    """
    blurred = blur(frame, background.blur_px)
    return np.asarray(cv2.subtract(blurred, background.ceiling), dtype=np.uint8)


def brightening_entropy(
    filtered: Frame, *, bins: int = GREY_LEVELS, grey: Grey = "luma", rounding: Rounding = "nearest"
) -> float:
    """Shannon entropy of the histogram of the grey image: E = -sum of p_i log2 p_i over the bins with p_i > 0 [bit].

    p_i is the share of pixels in bin i of 2..256; level g of 0..255 falls into bin floor(g bins / 256). E lies in
    0..log2(bins) and is 0 where all pixels fall into one bin.
    """
    levels = grey_image(filtered, grey, rounding)
    counts = cv2.calcHist([levels], [0], None, [bins], [0, GREY_LEVELS]).ravel().astype(np.float64)
    share = counts[counts > 0] / levels.size
    return max(0.0, -float(np.dot(share, np.log2(share))))


def grey_image(filtered: Frame, grey: Grey = "luma", rounding: Rounding = "nearest") -> npt.NDArray[np.uint8]:
    """The filtered channels as one 8-bit grey image, shape (rows, columns).

    All in whole numbers. OpenCV's rounded luma has weights in 2^-15, so it can differ from the decimal weights where a
    level lies within 0.005 of a half.
    """
    if grey == "luma" and rounding == "nearest":
        return np.asarray(cv2.cvtColor(filtered, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
    weights, scale = (_LUMA_THOUSANDTHS, 1000) if grey == "luma" else ((1, 1, 1), 3)
    red, green, blue = (weight * filtered[:, :, index].astype(np.uint32) for index, weight in enumerate(weights))
    total = red + green + blue
    levels = (2 * total + scale) // (2 * scale) if rounding == "nearest" else total // scale
    return levels.astype(np.uint8)


def brightening_correlation(filtered: Frame, *, constant: ConstantChannel = "zero") -> float:
    """Mean of the pairwise Pearson correlations between the channels: C = (r_rg + r_rb + r_gb) / 3, -1..1.

    r_xy = (n sum x y - sum x sum y) / sqrt((n sum x x - (sum x)^2) (n sum y y - (sum y)^2)) over the n pixels; a pair
    with a constant channel, whose root is 0, counts as 0 (`zero`) or is left out of the mean (`skip`). C is 0 where no
    pair has a correlation. The sums are whole numbers, so neither cancellation nor the order of pixels changes the
    result; the sum of x y comes from the squared differences as (sum of x x + sum of y y - sum of (x - y)(x - y)) / 2.
    """
    planes = cv2.split(filtered)
    pixels = planes[0].size
    # OpenCV's floats may be squared roots and off in the last bit; what is behind them is whole.
    sums = [round(cv2.sumElems(plane)[0]) for plane in planes]
    squares = [round(cv2.norm(plane, cv2.NORM_L2SQR)) for plane in planes]
    variances = [pixels * square - total * total for square, total in zip(squares, sums, strict=True)]
    total, counted = 0.0, 0
    for first, second in combinations(range(len(planes)), 2):
        if variances[first] == 0 or variances[second] == 0:
            counted += constant == "zero"
            continue
        difference = round(cv2.norm(planes[first], planes[second], cv2.NORM_L2SQR))
        product = (squares[first] + squares[second] - difference) // 2
        covariance = pixels * product - sums[first] * sums[second]
        total += covariance / math.sqrt(variances[first] * variances[second])
        counted += 1
    return min(1.0, max(-1.0, total / counted)) if counted else 0.0


def brightening(filtered: Frame, profile: DetectorProfile) -> tuple[float, float]:
    """E [bit] and C of the filtered channels by a profile's options."""
    return (
        brightening_entropy(filtered, bins=profile.entropy_bins, grey=profile.grey, rounding=profile.grey_rounding),
        brightening_correlation(filtered, constant=profile.constant_channel),
    )


def decide_proximity(entropy: float, correlation: float, profile: DetectorProfile) -> Proximity:
    """E < tau_e: Normal; else C < tau_c: Approaching; else Noise."""
    if entropy < profile.tau_e:
        return Proximity.NORMAL
    return Proximity.APPROACHING if correlation < profile.tau_c else Proximity.NOISE


Overlap = tuple[float, float, float]
"""Areas of one channel [px]: sum of b g, sum of b and sum of g, with a frame's mask b and a reference g."""
_RATIOS: Mapping[Similarity, Callable[[float, float, float], float]] = {
    "recall": lambda shared, _, wanted: shared / wanted,
    "iou": lambda shared, shown, wanted: shared / (shown + wanted - shared),
    "dice": lambda shared, shown, wanted: 2 * shared / (shown + wanted),
}


def grid_areas(frame: Frame, grid: GridReference) -> list[Overlap]:
    """Overlap of a frame's grid with a reference of the same shape, (rows, columns, 3), for each channel.

    The frame's mask b is 0 or 1 and the reference g is the share of frames in 0..1. For such a pair the
    fuzzy-set intersection min(b, g) and the probabilistic one b g are the same, and so are the unions
    max(b, g) and b + g - b g, so that no choice between them is needed.
    """
    return mask_areas(levelled(blur(frame, grid.blur_px, grid.blur_sigma_px), grid.surround_px), grid)


def mask_areas(blurred: Frame, grid: GridReference) -> list[Overlap]:
    """Overlaps of a frame that is blurred and levelled already."""
    mask = grid_mask(blurred, tau_b=grid.tau_b, polarity=grid.polarity)
    shared, shown = cv2.sumElems(cv2.bitwise_and(grid.counts, mask)), cv2.sumElems(mask)
    channels = zip(shared, shown, grid.areas, strict=False)  # OpenCV sums four channels
    return [(both / grid.frames, one / FULL, other / grid.frames) for both, one, other in channels]


def grid_similarity(areas: Sequence[Overlap], similarity: Similarity) -> float:
    """Mean similarity S, 0..1, over the channels whose reference shows the grid, of which there is at least one.

    With i the intersection, f the frame's area and r the reference's: `recall` = i / r (published),
    `iou` = i / (f + r - i), `dice` = 2 i / (f + r). 1 means the grid is undisturbed.
    """
    values = [_RATIOS[similarity](*channel) for channel in areas if channel[-1] > 0]
    return sum(values) / len(values)


def decide_contact(similarity: float, profile: DetectorProfile) -> Contact:
    """S < tau_g: Touched; else Untouched."""
    return Contact.TOUCHED if similarity < profile.tau_g else Contact.UNTOUCHED


Features = npt.NDArray[np.float64]
"""One feature of every scored frame, shape (frames,)."""
GridOption = tuple[int, Polarity, int, int]
"""tau_b, polarity, grid blur [px] and surroundings [px]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """Frames that share one set of references."""

    references: Sequence[Frame]
    """Frames of the untouched sensor in their order, each (rows, columns, 3)."""
    frames: Sequence[Frame]
    """Frames to judge, each (rows, columns, 3)."""
    classes: Sequence[FrameClass | None]
    """True class of each frame; None leaves it out."""

    def __post_init__(self) -> None:
        """Refuse classes that do not match the frames."""
        if len(self.frames) != len(self.classes):
            msg = f"episode has {len(self.frames)} frames and {len(self.classes)} classes; must be one for each"
            raise ConfigError(msg)


def scored_classes(episodes: Iterable[Episode]) -> list[FrameClass]:
    """Classes of the scored frames of all episodes, in order."""
    return [each for episode in episodes for each in episode.classes if each is not None]


def measure_brightening(
    episodes: Iterable[Episode], base: DetectorProfile, difference_blur_px: int
) -> tuple[Features, Features]:
    """Entropy E [bit] and correlation C of the scored frames, each of shape (frames,).

    The base gives the numbers of references and of reference frames, and the options of entropy and correlation.
    `FrameError` where a frame is not an image of its episode's size, or an episode has too few references.
    """
    found: list[tuple[float, float]] = []
    for episode in episodes:
        references, frames = _checked(episode, base)
        background = fuse_background(references, count=base.background_count, blur_px=difference_blur_px)
        found += [brightening(filter_channels(frame, background), base) for frame in frames]
    entropy, correlation = np.array(found, np.float64).reshape(-1, 2).T
    return entropy, correlation


def measure_similarity(
    episodes: Iterable[Episode],
    base: DetectorProfile,
    options: Sequence[GridOption],
    similarities: Sequence[Similarity],
) -> Mapping[tuple[GridOption, Similarity], Features | None]:
    """Grid similarity S of the scored frames for every option and measure, each of shape (frames,).

    A frame is blurred and levelled once for each pair of kernels and binarised once for each option, whatever the
    measures and however often an option is given. S is None for an option under which the references of an episode show
    no grid.
    """
    values: dict[tuple[GridOption, Similarity], list[float]] = {each: [] for each in product(options, similarities)}
    empty: set[GridOption] = set()
    for episode in episodes:
        references, frames = _checked(episode, base)
        for size, surround_px in sorted({option[2:] for option in options}):
            level = [levelled(blur(frame, size, base.grid_blur_sigma_px), surround_px) for frame in frames]
            for option in dict.fromkeys(options):
                if option[2:] != (size, surround_px) or option in empty:
                    continue
                tau_b, polarity = option[:2]
                try:
                    one = replace(base, tau_b=tau_b, polarity=polarity, grid_blur_px=size, surround_px=surround_px)
                    grid = fuse_grid(references, one)
                except FrameError:
                    empty.add(option)
                    continue
                areas = [mask_areas(image, grid) for image in level]
                for similarity in dict.fromkeys(similarities):
                    values[option, similarity] += [grid_similarity(each, similarity) for each in areas]
    return {key: None if key[0] in empty else np.array(each) for key, each in values.items()}


def _checked(episode: Episode, base: DetectorProfile) -> tuple[list[Frame], list[Frame]]:
    """The reference frames that `fuse` would take, and the frames that have a class."""
    taken = episode.references[: base.reference_count]
    if len(taken) < base.background_count:
        raise FrameError(f"episode has {len(taken)} reference frame(s); must be at least {base.background_count}")
    shape = check_frame(taken[0]).shape
    scored = [frame for frame, each in zip(episode.frames, episode.classes, strict=True) if each is not None]
    references, frames = ([check_frame(each, shape=shape) for each in images] for images in (taken, scored))
    return references, frames
