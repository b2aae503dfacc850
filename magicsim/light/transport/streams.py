"""Random streams that one seed owns: what of a frame draws its own numbers, each from a stream of its own.

Lights have the first streams after the camera's, in their order.
"""

from typing import Any

from magicsim.light.backend import dr, mi

SEEDS_PER_RENDER = 64
"""Streams of one seed: the camera's is the first, a light's one more than its number."""
MIRRORED = SEEDS_PER_RENDER - 1
"""Camera paths that something outside sends on."""
LIGHT_BACK = SEEDS_PER_RENDER - 2
"""Recorded light that something outside sends on."""
ON_OBJECT = SEEDS_PER_RENDER - 3
"""Rays from the object."""
ROOM_ON_OBJECT = SEEDS_PER_RENDER - 4
"""The room's beam around the object."""
ROOM_BACK = SEEDS_PER_RENDER - 5
"""The room's recorded light that something outside sends on."""
FACING = SEEDS_PER_RENDER - 6
"""Light of a facing finger."""
PASSING = SEEDS_PER_RENDER - 7
"""Light of what passes in the room, through the opening of the housing."""
PASSING_ON_OBJECT = SEEDS_PER_RENDER - 8
"""Light of what passes in the room, around an object."""
COAT = SEEDS_PER_RENDER - 9
"""What is seen from an opaque coat."""


def generators(dimensions: int) -> list[int]:
    """Increments of R_d as 32-bit integers: 2^32 / g^k, where g^(d + 1) = g + 1."""
    golden = 2.0
    for _ in range(64):
        golden = (1 + golden) ** (1 / (dimensions + 1))
    return [round(2.0**32 / golden ** (k + 1)) % 2**32 for k in range(dimensions)]


def sequence(index: Any, shift: list[Any]) -> list[Any]:
    """Low-discrepancy points number `index`, shifted on the torus, one mi.Float in [0, 1) a dimension.

    The additive recurrence on powers of the generalised golden ratio (Roberts 2018, R_d), computed modulo 2^32 in
    integers, so that it stays exact for any index.
    """
    steps = generators(len(shift))
    # The upper 24 bits are what a float32 holds below 1.
    return [
        mi.Float((index * mi.UInt32(step) + offset) >> 8) * dr.scalar.Float(2.0**-24)
        for step, offset in zip(steps, shift, strict=True)
    ]
