"""The cells of a print: walls of uneven thickness, grid planes that wave, a pitch and a skin unlike the drawn ones.

Waves are a sum of plane waves of one length and random directions and phases, which is a Gaussian random field for
many of them; neighbouring cells share it, so that walls bend with them and keep their thickness.
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.flaws.unevenness import CUTOFF_SKIN_SD, Unevenness
from magicsim.geometry.grid import CellGrid

WAVES = 48
STREAM, SKIN_STREAM = 0x9E37, 0x5C1F
"""Keep a print's random numbers apart from others of that seed."""
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
    waves = _waves(vertices, unevenness.wave_sd_mm, unevenness.wave_length_mm, 3, random)
    printed = np.asarray(centres + share * (vertices - centres) + waves)
    if unevenness.shifts_cells:
        low = grid.origin_mm
        printed += unevenness.shift_mm(vertices, low, low + grid.pitch_mm * grid.counts)
        printed[:, 2] += _skin(vertices, grid, unevenness)
    return printed


def _skin(places: Array, grid: CellGrid, unevenness: Unevenness) -> Array:
    """How far an uneven skin lifts what is drawn at places: all on the lowest faces, nothing above the lowest cells."""
    if unevenness.skin_sd_mm == 0:
        return np.zeros(len(places))
    random = np.random.default_rng(np.random.SeedSequence([unevenness.seed, SKIN_STREAM]))
    limit = CUTOFF_SKIN_SD * unevenness.skin_sd_mm
    rise = _waves(places[:, :2], unevenness.skin_sd_mm, unevenness.skin_length_mm, 1, random)[:, 0]
    below = grid.centres_mm()[0, 2] + grid.cell_mm[2] / 2 - places[:, 2]
    return np.asarray(np.clip(rise, -limit, limit) * np.clip(below / grid.cell_mm[2], 0, 1))


def _waves(places: Array, spread: float, length: float, count: int, random: np.random.Generator) -> Array:
    """Smooth random fields at places in a plane or in space, shape (places, fields), in the unit of their spread."""
    axes = places.shape[1]
    directions = random.standard_normal((count, WAVES, axes))
    directions *= 2 * np.pi / length / np.linalg.norm(directions, axis=2, keepdims=True)
    phases = random.uniform(0, 2 * np.pi, (count, WAVES))
    height = spread * np.sqrt(2 / WAVES)
    sums = [np.cos(places @ directions[field].T + phases[field]).sum(1) for field in range(count)]
    return np.asarray(height * np.stack(sums, axis=1))
