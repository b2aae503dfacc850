"""Proximity: is something near, or is there light from outside?

Published as the second algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382). An object seen
through side-lit coloured light brightens the channels differently; a flashlight brightens them alike.
"""

import math
from itertools import combinations

import cv2
import numpy as np

from magicsim.detectors.frame import Frame
from magicsim.detectors.fusion import BackgroundReference
from magicsim.detectors.grid import blur
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Proximity


def filter_channels(frame: Frame, background: BackgroundReference) -> Frame:
    """What brightens against every background reference, per channel.

    The published loop F_j = F_(j-1) intersect max(F - B_j, 0), with F_0 = F and the pixelwise minimum as the
    intersection of grey images, equals max(F - max_j B_j, 0), which is what is computed.

    Args:
        frame: Shape (rows, columns, 3).
        background: References of the same shape.

    Returns:
        The brightening in grey levels, shape (rows, columns, 3).
    """
    blurred = blur(frame, background.blur_px)
    return np.asarray(cv2.subtract(blurred, background.ceiling), dtype=np.uint8)


def brightening_entropy(filtered: Frame) -> float:
    """Shannon entropy E [bit] of the 256-bin histogram of the grey image, which is rounded to 8 bit.

    Args:
        filtered: From `filter_channels`, shape (rows, columns, 3); grey = 0.299 R + 0.587 G + 0.114 B.

    Returns:
        E in 0..8; 0 where all pixels have one grey level.
    """
    grey = cv2.cvtColor(filtered, cv2.COLOR_RGB2GRAY)
    counts = cv2.calcHist([grey], [0], None, [256], [0, 256]).ravel().astype(np.float64)
    share = counts[counts > 0] / grey.size
    return max(0.0, -float(np.dot(share, np.log2(share))))


def brightening_correlation(filtered: Frame) -> float:
    """Mean C of the three pairwise Pearson correlations between the channels; a constant channel gives 0.

    The sums are whole numbers, so neither cancellation nor the order of pixels changes the result; the sum of
    x y comes from the squared differences as (sum of x x + sum of y y - sum of (x - y)(x - y)) / 2.

    Args:
        filtered: From `filter_channels`, shape (rows, columns, 3).

    Returns:
        C in -1..1.
    """
    planes = cv2.split(filtered)
    pixels = planes[0].size
    sums = [_whole(cv2.sumElems(plane)[0]) for plane in planes]
    squares = [_whole(cv2.norm(plane, cv2.NORM_L2SQR)) for plane in planes]
    variances = [pixels * square - total * total for square, total in zip(squares, sums, strict=True)]
    total = 0.0
    pairs = list(combinations(range(len(planes)), 2))
    for first, second in pairs:
        if variances[first] == 0 or variances[second] == 0:
            continue
        difference = _whole(cv2.norm(planes[first], planes[second], cv2.NORM_L2SQR))
        product = (squares[first] + squares[second] - difference) // 2
        covariance = pixels * product - sums[first] * sums[second]
        total += covariance / math.sqrt(variances[first] * variances[second])
    return min(1.0, max(-1.0, total / len(pairs)))


def _whole(total: float) -> int:
    """The whole number behind OpenCV's float, which may be a squared root and off in the last bit."""
    return round(total)


def decide_proximity(entropy: float, correlation: float, profile: DetectorProfile) -> Proximity:
    """E < tau_e: Normal; else C < tau_c: Approaching; else Noise."""
    if entropy < profile.tau_e:
        return Proximity.NORMAL
    return Proximity.APPROACHING if correlation < profile.tau_c else Proximity.NOISE
