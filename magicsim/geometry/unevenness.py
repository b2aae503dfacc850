"""How the cells of a print differ from its drawing: walls of uneven thickness, and grid planes that wave.

Waves are a sum of plane waves of one length and random directions and phases, which is a Gaussian random field for
many of them; neighbouring cells share it, so that walls bend with them and keep their thickness.
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.design import Unevenness
from magicsim.geometry.grid import CellGrid

WAVES = 48
STREAM = 0x9E37
"""Keeps a print's random numbers apart from others of that seed."""
CUTOFF_SD = 2.0
"""A wall differs from the drawing by at most so many standard deviations."""


def printed_cells(vertices: Array, grid: CellGrid, unevenness: Unevenness) -> Array:
    """Vertices of all cells as printed, shape (vertices, 3) [mm].

    Args:
        vertices: As drawn, cell after cell, of the same shape [mm].
        grid: The cells.
        unevenness: How the print differs.
    """
    if unevenness.is_even:
        return vertices
    random = np.random.default_rng(np.random.SeedSequence([unevenness.seed, STREAM]))
    centres = np.repeat(grid.centres_mm(), len(vertices) // grid.cell_count, axis=0)
    # A wall takes half of what each of its two cells leaves: independent cells of sqrt(2) sd give it one sd.
    limit = np.sqrt(2) * unevenness.wall_sd_mm
    taken = np.clip(random.standard_normal((grid.cell_count, 3)), -CUTOFF_SD, CUTOFF_SD) * limit
    share = 1 - np.repeat(taken, len(vertices) // grid.cell_count, axis=0) / grid.cell_mm
    return np.asarray(centres + share * (vertices - centres) + _waves(vertices, unevenness, random))


def _waves(places: Array, unevenness: Unevenness, random: np.random.Generator) -> Array:
    """Smooth displacement at places, shape (places, 3) [mm]."""
    directions = random.standard_normal((3, WAVES, 3))
    directions *= 2 * np.pi / unevenness.wave_length_mm / np.linalg.norm(directions, axis=2, keepdims=True)
    phases = random.uniform(0, 2 * np.pi, (3, WAVES))
    height = unevenness.wave_sd_mm * np.sqrt(2 / WAVES)
    sums = [np.cos(places @ directions[axis].T + phases[axis]).sum(1) for axis in range(3)]
    return np.asarray(height * np.stack(sums, axis=1))
