"""Random numbers of a camera: a generator of its own for each thing that varies, found by seed and place alone."""

import numpy as np

PATTERN_STREAM = 2**31
"""Streams from here on are beyond every frame's. This one: what belongs to the camera."""
DRIFT_STREAM = PATTERN_STREAM + 1
"""Wander of the LEDs of an episode."""
PHASE_STREAM = PATTERN_STREAM + 2
"""Where in its swing the mains light begins."""
ROWS, SHAKE = 1, 2
"""Parts of a frame's stream, beside its pixels' noise."""
DARK, HOT, DEAD, DUST = 1, 2, 3, 4
"""Parts of the pattern, beside the pixels' gains."""


def deviates(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    """The generator of one thing.

    Args:
        seed: Of the episode, or of the camera's pattern.
        stream: Number of the frame, or one of the streams above.
        part: Of the stream; 0 is the first.
    """
    words = [seed, stream, part] if part else [seed, stream]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))
