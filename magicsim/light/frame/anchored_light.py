"""Light of a frame, anchored to the untouched sensor: the anchor's light and what the frame changes beyond noise."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from magicsim.arrays import Array
from magicsim.kernels import kernel
from magicsim.light.transport.light_field import LightField

PATCHES = 200
"""Patches that a contact is taken as, about."""
Counts = tuple[int, int, int]
SMOOTHING_CELLS = (2.0, 4.0, 8.0)
"""Standard deviations of local means [cells]: the first below a scattering free path of 3 mm."""
CHANGED_SHARE = 0.15
"""Expected change of light, in units of what comes from the contact: a touched face sends back less than a bare one,
which reflects all light that comes slantwise, or more, as the object is dark or bright. A grey box on all of the face
changes light by 0.23 of that in the root mean square, balls and smaller boxes by 0.07 to 0.17
(`benchmarks/touch_light.py`); from 0.1 to 0.5 for other objects (assumed). Of a ball, a box and a long cylinder 0.15
leaves the smallest error: twice as much lets a tenth to a fifth more noise through."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """Shares of the light that may be others in a frame, see `contact_share`."""

    cells: Array
    """Share of each cell, shape (cells,)."""
    voxels: Array
    """Share of each voxel of the body, shape (voxels,)."""

    def size(self, fluence: Array) -> float:
        """Expected relative change of the light in the cells, root mean square, weighed by their fluence."""
        level = fluence.sum(1)
        whole = float(level.sum())
        return CHANGED_SHARE * float(np.sqrt((level * self.cells**2).sum() / whole)) if whole > 0 else 0.0


def anchored_light(
    now: LightField,
    control: LightField,
    anchor: LightField,
    counts: Counts | None,
    voxels: Counts | None,
    *,
    growth: Array | float = 1.0,
    expected: Expected | None = None,
) -> LightField:
    """The anchor's field, changed as much as a frame's differs from it, less the noise shared with the control's.

    What changes fluence from cell to cell is scattering over a free path of several cells, so the change is taken
    between local means: noise falls several times, and fields that equal the control ones give the anchor ones.
    Where it is known how large a change may be, only the part of it counts that is not noise. What was dark takes the
    frame's own light.

    Args:
        now: The light in the frame.
        control: In the untouched state with the frame's seed and particles.
        anchor: In the untouched state with many particles.
        counts: Cells along x, y and z, or None without a grid.
        voxels: Voxels of the body along x, y and z, or None where it does not scatter.
        growth: What each voxel holds of the body over what it held when untouched, shape (voxels, 1): a voxel that
            is squeezed empty is not a dark one.
        expected: How large changes may be, or None where all that is found counts.
    """
    cells, parts = (expected.cells, expected.voxels) if expected is not None else (None, None)
    fluence = _carried_over(now.fluence, control.fluence, anchor.fluence, counts, cells)
    body = _carried_over(now.body, growth * control.body, growth * anchor.body, voxels, parts)
    return replace(now, fluence=fluence, body=body)


def _carried_over(now: Array, control: Array, anchor: Array, counts: Counts | None, expected: Array | None) -> Array:
    """One part of the anchor's field, carried over to the frame."""
    if counts is None:
        return anchor
    noise = control - anchor
    share = _share(now - anchor, noise, anchor)
    change = now - anchor - share * noise
    if expected is None:
        relative = _ratio(*(_local_mean(each, counts, SMOOTHING_CELLS[0]) for each in (change, anchor)))
    else:
        relative = _known_part(change, noise, anchor, counts, CHANGED_SHARE * expected, 1 - share**2)
    return np.where(anchor > 0, anchor * np.maximum(1 + relative, 0), now)


def _known_part(change: Array, noise: Array, level: Array, counts: Counts, expected: Array, unshared: float) -> Array:
    """Relative change, of each length the part that is more than noise: Wiener's filter for a size that is expected.

    Lengths are the differences between local means of `SMOOTHING_CELLS`. Each counts by s^2 / (s^2 + n^2), with s^2 the
    local mean square of what is expected and n^2 the mean square of that length's noise.

    Args:
        change: What the frame changes, with noise, shape (cells, 3).
        noise: One sample of a state's noise, of the same shape.
        level: The anchor field, of the same shape.
        counts: Cells along x, y and z.
        expected: Relative size of the change, shape (cells,).
        unshared: Part of the noise's variance that the change still has, 0 to 1.
    """
    found, lit = np.zeros_like(change), level > 0
    if not lit.any():
        return found
    squares = np.broadcast_to(expected[:, None] ** 2, change.shape)
    parts = zip(_lengths(change, level, counts), _lengths(noise, level, counts), strict=True)
    for width, (part, own) in zip(SMOOTHING_CELLS, parts, strict=True):
        signal, variance = _local_mean(squares, counts, width), unshared * float((own[lit] ** 2).mean())
        found += part * np.divide(signal, signal + variance, out=np.zeros_like(signal), where=signal > 0)
    return found


def _lengths(values: Array, level: Array, counts: Counts) -> list[Array]:
    """Local means over those of the level, each less the next wider one; the last is as it is."""
    means = [_ratio(_local_mean(values, counts, width), _local_mean(level, counts, width)) for width in SMOOTHING_CELLS]
    return [fine - coarse for fine, coarse in pairwise(means)] + means[-1:]


def _share(change: Array, noise: Array, level: Array) -> float:
    """Part of the noise, 0 to 1, that a change holds: regression over all values, whose variance is as their level.

    The ratio of the two noisy fields, which takes off all of the noise, adds what they do not share.
    """
    squared = float(_ratio(noise**2, level).sum())
    return float(np.clip(_ratio(change * noise, level).sum() / squared, 0, 1)) if squared > 0 else 0.0


def _ratio(values: Array, level: Array) -> Array:
    return np.divide(values, level, out=np.zeros_like(level), where=level > 0)


def _local_mean(values: Array, counts: Counts, width: float) -> Array:
    return mean_of_cells(values, counts, width, mode="nearest", truncate=2.5)


def mean_of_cells(values: Array, counts: Counts, width: float, **options: Any) -> Array:
    """Gaussian mean over neighbouring cells, shape (cells, 3), cells in x-fastest order; options are SciPy's."""
    grid = values.reshape(*counts[::-1], 3)
    return gaussian_filter(grid, (width,) * 3 + (0.0,), **options).reshape(-1, 3)


def contact_share(places_mm: Array, vertices_mm: Array, faces: npt.NDArray[np.int32]) -> Array:
    """How much of the light at places comes from a contact: its solid angle over 2 pi, at most 1, shape (places,).

    Light that leaves a small patch of the face in all directions alike brings a place the patch's solid angle there
    over that of a hemisphere, if light otherwise comes alike from all around. A contact replaces what a bare face sends
    back by what the object does, so the share is about the largest relative change, and far from a small contact it is
    next to nothing. It serves as the expected size of a change that is measured with noise, not as the change.
    """
    if not len(faces):
        return np.zeros(len(places_mm))
    corners = vertices_mm[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    centres, areas = _patches(corners.mean(1), area)
    return np.asarray(_shares(places_mm, centres, areas))


@kernel()
def _shares(places, centres, areas):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Solid angle of patches over 2 pi, at most 1, at each place, shape (places,)."""
    shares = np.zeros(len(places))
    for place in range(len(places)):
        for patch in range(len(areas)):
            # A patch is no point: on it, it is all of a hemisphere.
            size = areas[patch] / (2 * np.pi)
            x = places[place, 0] - centres[patch, 0]
            y = places[place, 1] - centres[patch, 1]
            z = places[place, 2] - centres[patch, 2]
            squared = x * x + y * y + z * z + size
            shares[place] += areas[patch] * np.sqrt((z * z + size) / squared) / squared
        shares[place] = min(shares[place] / (2 * np.pi), 1.0)
    return shares


def _patches(centres: Array, area: Array) -> tuple[Array, Array]:
    """Triangles of one square of the face taken together: centres, shape (patches, 3) [mm], and areas [mm2]."""
    low, high = centres[:, :2].min(0), centres[:, :2].max(0)
    edge = max(1e-9, float(np.sqrt(np.prod(high - low + 1e-9) / PATCHES)), float((high - low).max()) / PATCHES)
    _, patch = np.unique(np.floor((centres[:, :2] - low) / edge).astype(np.int64), axis=0, return_inverse=True)
    areas = np.asarray(np.bincount(patch.ravel(), area), np.float64)
    weighted = [np.bincount(patch.ravel(), area * centres[:, axis]) for axis in range(3)]
    return np.stack(weighted, 1) / np.maximum(areas, 1e-30)[:, None], areas
