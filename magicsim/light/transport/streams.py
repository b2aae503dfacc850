"""Random streams that one seed owns: what of a frame draws its own numbers, each from a stream of its own.

Lights have the first streams after the camera's, in their order.
"""

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
"""Its light around an object."""
