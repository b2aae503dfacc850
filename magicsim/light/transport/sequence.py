"""Low-discrepancy points: the additive recurrence on powers of the generalised golden ratio (Roberts 2018, R_d).

Computed modulo 2^32 in integers, so that it stays exact for any index.
"""

from typing import Any

from magicsim.light.backend import dr, mi


def generators(dimensions: int) -> list[int]:
    """Increments of R_d as 32-bit integers: 2^32 / g^k, where g^(d + 1) = g + 1."""
    golden = 2.0
    for _ in range(64):
        golden = (1 + golden) ** (1 / (dimensions + 1))
    return [round(2.0**32 / golden ** (k + 1)) % 2**32 for k in range(dimensions)]


def sequence(index: Any, shift: list[Any]) -> list[Any]:
    """Points number `index` of R_d, shifted on the torus.

    Args:
        index: mi.UInt32 of any width.
        shift: One mi.UInt32 a dimension, of the same width or 1.

    Returns:
        One mi.Float in [0, 1) a dimension.
    """
    steps = generators(len(shift))
    # The upper 24 bits are what a float32 holds below 1.
    return [
        mi.Float((index * mi.UInt32(step) + offset) >> 8) * dr.scalar.Float(2.0**-24)
        for step, offset in zip(steps, shift, strict=True)
    ]
