"""Proximity: is something near, or is there light from outside?

Published as the second algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382). An object seen
through side-lit coloured light brightens the channels differently; a flashlight brightens them alike.
"""

import math
from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.detectors.fusion import BackgroundReference, blur
from magicsim.detectors.profile import ConstantChannel, DetectorProfile, Grey, Rounding
from magicsim.detectors.verdict import Proximity

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
    sums = [_whole(cv2.sumElems(plane)[0]) for plane in planes]
    squares = [_whole(cv2.norm(plane, cv2.NORM_L2SQR)) for plane in planes]
    variances = [pixels * square - total * total for square, total in zip(squares, sums, strict=True)]
    total, counted = 0.0, 0
    for first, second in combinations(range(len(planes)), 2):
        if variances[first] == 0 or variances[second] == 0:
            counted += constant == "zero"
            continue
        difference = _whole(cv2.norm(planes[first], planes[second], cv2.NORM_L2SQR))
        product = (squares[first] + squares[second] - difference) // 2
        covariance = pixels * product - sums[first] * sums[second]
        total += covariance / math.sqrt(variances[first] * variances[second])
        counted += 1
    return min(1.0, max(-1.0, total / counted)) if counted else 0.0


def _whole(total: float) -> int:
    """The whole number behind OpenCV's float, which may be a squared root and off in the last bit."""
    return round(total)


def decide_proximity(entropy: float, correlation: float, profile: DetectorProfile) -> Proximity:
    """E < tau_e: Normal; else C < tau_c: Approaching; else Noise."""
    if entropy < profile.tau_e:
        return Proximity.NORMAL
    return Proximity.APPROACHING if correlation < profile.tau_c else Proximity.NOISE
