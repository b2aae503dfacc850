"""The light field as the camera pass looks it up: a linear function in every cell and in every voxel of the body."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from magicsim.arrays import Array
from magicsim.light.aligned import aligned
from magicsim.light.backend import dr, mi
from magicsim.light.transport.voxels import BodyPart, Voxels

AXES = 3


class Elements(NamedTuple):
    """A field that is linear in each of many elements."""

    values: Array
    """Mean of each element, shape (elements, 3 channels)."""
    slopes: Array
    """Along x, y and z, shape (elements, 3 axes, 3 channels) [1/mm]."""
    centres_mm: Array
    """Shape (elements, 3) [mm]."""


@dataclass(slots=True, kw_only=True)
class Piecewise:
    """A field that is linear in each of many elements, three channels; arrays on the renderer's side."""

    values: Any
    """Mean of each element and channel, mi.Float of size 3 * elements."""
    slopes: Any
    """Along x, y and z in each element, mi.Float of size 9 * elements, channel after axis [1/mm]."""
    centres: Any
    """Centres of the elements, mi.Float of size 3 * elements [mm]."""
    is_change: bool = False
    """Whether values of either sign are meant; otherwise none is negative."""

    @classmethod
    def of(cls, elements: Elements, *, is_change: bool) -> Self:
        """The field of arrays of NumPy."""
        values, slopes, centres = (flat(each) for each in elements)
        return cls(values=values, slopes=slopes, centres=centres, is_change=is_change)

    def at(self, element: Any, point: Any, active: Any) -> Any:
        """Value at a point of an element."""
        centre = [dr.gather(mi.Float, self.centres, 3 * element + axis, active) for axis in range(3)]
        channels = []
        for channel in range(3):
            value = dr.gather(mi.Float, self.values, 3 * element + channel, active)
            for axis in range(3):
                slope = dr.gather(mi.Float, self.slopes, 9 * element + 3 * axis + channel, active)
                value = dr.fma(slope, point[axis] - centre[axis], value)
            channels.append(value if self.is_change else dr.maximum(value, 0))
        return mi.Color3f(*channels)


@dataclass(slots=True, kw_only=True)
class VoxelField:
    """A field on voxels."""

    voxels: Voxels
    field: Piecewise

    def at(self, point: Any, active: Any) -> Any:
        """Value at a point."""
        return self.field.at(self.voxels.index(point), point, active)


@dataclass(slots=True, kw_only=True)
class CachedLight:
    """A light field on the renderer's side."""

    cells: Piecewise
    """Fluence of the infill cells."""
    body: VoxelField | None
    """Fluence of the body, or None where it does not scatter."""
    irradiance: Any
    """Irradiance of the object's triangles and channels, mi.Float of size 3 * triangles."""

    def on_object(self, triangle: Any, active: Any) -> Any:
        """Irradiance of a triangle of the object."""
        return mi.Color3f(*[dr.gather(mi.Float, self.irradiance, 3 * triangle + c, active) for c in range(3)])


def flat(values: Array) -> Any:
    """An array on the renderer's side, mi.Float of its size."""
    return mi.Float(aligned(values, np.float32).ravel())


def cell_elements(fluence: Array, centres_mm: Array | None, counts: tuple[int, int, int]) -> Elements:
    """Light in the cells, see `cell_slopes`; without a grid there is one of them, which holds none."""
    if centres_mm is None:
        return Elements(fluence, np.zeros((1, AXES, 3)), np.zeros((1, AXES)))
    return Elements(fluence, cell_slopes(fluence, centres_mm, counts), centres_mm)


def body_elements(light: Array, part: BodyPart, voxels: Voxels) -> Elements:
    """Light in the voxels of a body, with slopes between the LED strips.

    Args:
        light: Fluence times what each voxel holds of the body, shape (voxels, 3) [mm3].
        part: What they hold.
        voxels: Where they are.
    """
    held = part.held_mm3[:, None]
    fluence = np.divide(light, held, out=np.zeros_like(light), where=held > 0)
    slopes, inner = np.zeros((len(fluence), AXES, 3)), voxels.inner
    slopes[inner] = cell_slopes(fluence[inner], part.centres_mm[inner], voxels.inner_counts)
    return Elements(fluence, slopes, part.centres_mm)


def cell_slopes(fluence: Array, centres: Array, counts: tuple[int, int, int]) -> Array:
    """Slopes of the fluence inside each cell, by central differences between the means of its neighbours.

    A fluence of constant cells is wrong by its change across a cell, 2 % beside the LEDs; a linear one by its
    curvature. The difference of neighbours is nearly free of the noise that a fit inside the cell would have. At the
    rim of the grid it is one-sided; along an axis with a single cell there is none.

    Args:
        fluence: Mean of each cell and channel, cells x fastest, shape (cells, 3).
        centres: Of the cells as they are deformed, shape (cells, 3) [mm].
        counts: Cells along x, y and z.

    Returns:
        Shape (cells, 3 axes, 3 channels) [1/mm].
    """
    nx, ny, nz = counts
    along = [axis for axis in range(3) if counts[axis] > 1]
    result = np.zeros((len(fluence), 3, 3))
    if not along:
        return result

    def steps(values: Array) -> Array:
        grid = values.reshape(nz, ny, nx, -1)
        return np.stack([np.gradient(grid, axis=2 - axis).reshape(len(values), -1) for axis in along], 1)

    if len(along) == AXES:
        result[:] = np.linalg.solve(steps(centres), steps(fluence))
    else:
        # Along an axis with a single cell nothing is known: the shortest solution has no slope there.
        result[:] = np.linalg.pinv(steps(centres)) @ steps(fluence)
    return result
