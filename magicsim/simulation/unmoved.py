"""Vertices that a press has hardly moved stay where they are, and light there takes the paths of the untouched sensor.

After a few refractions a displacement of a micrometre sends a path through another cell. Rendered as they are, such
displacements would change nothing that can be seen but every random choice, all over the image: its noise would tell
that something touches.
"""

import numpy as np

from magicsim.arrays import Array

FADE = 8.0
"""Displacement, in units of the bound, from which on it is rendered as it is: strains grow by 22 % at most."""


def still(vertices: Array, rest: Array, bound_mm: float) -> Array:
    """Vertices less the part of their displacement that is left out, which is nowhere more than the bound.

    Up to the bound all of a displacement is left out, beyond it as much as the bound at first and then less and less.

    Args:
        vertices: Where they are, shape (vertices, 3) [mm].
        rest: Where they were when nothing touched, of the same shape [mm].
        bound_mm: The most that is left out [mm]; 0 leaves out nothing.
    """
    if bound_mm == 0:
        return vertices
    moved = vertices - rest
    way = np.linalg.norm(moved, axis=1, keepdims=True)
    t = np.clip((way / bound_mm - 1) / (FADE - 1), 0, 1)
    kept = np.maximum(way - bound_mm * (1 - t * t * (3 - 2 * t)), 0)
    return np.asarray(rest + moved * np.divide(kept, way, out=np.zeros_like(way), where=way > 0))
