"""When a gain that is corrected late still settles.

The relative error e of a brightness whose logarithm is corrected by a share a of the error seen d frames ago follows
e(k + 1) = e(k) - a e(k - d). It decays where 0 < a < 2 cos(pi d / (2 d + 1)) (Levin and May, *Theor. Popul. Biol.* 9,
178, 1976).
"""

import math


def correction_share(time_constant_frames: float) -> float:
    """Part of the error that is corrected in a frame, so that it falls to 1/e in so many frames."""
    return -math.expm1(-1 / time_constant_frames)


def largest_share(delay_frames: int) -> float:
    """The bound of what may be corrected in a frame."""
    return 2 * math.cos(math.pi * delay_frames / (2 * delay_frames + 1))


def least_frames(delay_frames: int) -> float:
    """The bound of the time constant [frames]; 0 where any settles."""
    largest = largest_share(delay_frames)
    return -1 / math.log1p(-largest) if largest < 1 else 0.0
