"""The light field as the camera pass looks it up: a linear function in every cell and in every voxel of the body."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.light.backend import box_number, dr, floats, mi
from magicsim.light.world.medium import classify, free_path
from magicsim.light.world.shapes import Shapes

PLAIN_MM = 1.0
"""Edge of a voxel where there is no grid, whose pitch is taken otherwise [mm]."""
LAYERS = 6
"""Fewest layers of voxels in a thin block without a grid."""
POINTS = 5
"""Points along each edge of a voxel that say how much of it is body."""
PADDING = (1, 1, 0)
"""Layers of voxels on each side along x, y and z behind the LED strips, where it is dark."""
LEAST_SHARE = 0.02
"""Voxels with less body than this share hold no fluence: too little is known of them."""
AXES = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyPart:
    """What voxels hold of the body in one state."""

    held_mm3: Array
    """Volume, shape (voxels,) [mm3]; 0 where it is next to nothing."""
    centres_mm: Array
    """Centroid, shape (voxels, 3) [mm]."""


@dataclass(slots=True, kw_only=True)
class Voxels:
    """A regular grid that holds the fluence of the body, one connected region that walls and skin share.

    It stands still while the sensor deforms; what a voxel holds of the body is counted by rays in every state. Boxes
    are in the sensor's frame, x fastest; points outside count to the nearest one.
    """

    origin_mm: tuple[float, float, float]
    size_mm: tuple[float, float, float]
    counts: tuple[int, int, int]

    @property
    def count(self) -> int:
        """Number of voxels."""
        return int(np.prod(self.counts))

    @property
    def inner_counts(self) -> tuple[int, int, int]:
        """Voxels between the LED strips along x, y and z."""
        x, y, z = (count - 2 * layers for count, layers in zip(self.counts, PADDING, strict=True))
        return x, y, z

    @property
    def inner(self) -> npt.NDArray[np.intp]:
        """Numbers of the voxels between the LED strips, x fastest."""
        numbers = np.arange(self.count).reshape(self.counts[::-1])
        x, y, z = (slice(layers, count - layers) for layers, count in zip(PADDING, self.counts, strict=True))
        return numbers[z, y, x].ravel()

    def index(self, point: Any) -> Any:
        """Number of the voxel that holds a point."""
        return box_number(point, self.origin_mm, self.size_mm, self.counts)

    def body_part(self, scene: Any, shapes: Shapes) -> BodyPart:
        """What each voxel holds of the body in the scene's present state."""
        per_voxel = POINTS**3
        lane = dr.arange(mi.UInt32, self.count * per_voxel)
        voxel, point = lane // per_voxel, lane % per_voxel
        random = mi.PCG32(size=self.count * per_voxel)
        steps = (point % POINTS, (point // POINTS) % POINTS, point // POINTS**2)
        x, y = voxel % self.counts[0], (voxel // self.counts[0]) % self.counts[1]
        places = (x, y, voxel // (self.counts[0] * self.counts[1]))
        position = [
            (mi.Float(place) + (mi.Float(step) + random.next_float32()) / POINTS) * size + origin
            for place, step, size, origin in zip(places, steps, self.size_mm, self.origin_mm, strict=True)
        ]
        si = scene.ray_intersect(mi.Ray3f(mi.Point3f(*position), mi.Vector3f(0, 0, 1)))
        body, infill, _ = shapes.pointers()
        segment = classify(si, body, infill, mi.Bool(False), shapes.openings)
        inside = dr.select(segment.in_body, mi.Float(1), mi.Float(0))
        points = np.array(dr.block_sum(inside, per_voxel), np.float64)
        sums = [np.array(dr.block_sum(inside * axis, per_voxel), np.float64) for axis in position]
        known = points > LEAST_SHARE * per_voxel
        centres = np.stack(sums, 1) / np.maximum(points, 1)[:, None]
        centres[~known] = np.stack([np.array(axis).reshape(-1, per_voxel).mean(1) for axis in position], 1)[~known]
        held = np.where(known, points / per_voxel * np.prod(self.size_mm), 0.0)
        return BodyPart(held_mm3=held, centres_mm=centres)


def body_voxels(elastomer: Elastomer, inset_mm: float) -> Voxels:
    """Voxels as large as the grid's pitch, with faces where the LED strips shine from, and one more layer outside."""
    design = elastomer.design
    size = np.array([*design.footprint_mm, design.height_mm]) - [2 * inset_mm, 2 * inset_mm, 0]
    plain = min(PLAIN_MM, design.height_mm / LAYERS)
    wanted = elastomer.grid.pitch_mm if elastomer.grid is not None else np.full(3, plain)
    inner = np.maximum(1, np.round(size / wanted)).astype(int)
    edge = size / inner
    outer = np.array(PADDING)
    origin = np.array([-size[0] / 2, -size[1] / 2, 0.0]) - outer * edge
    x, y, z = (inner + 2 * outer).tolist()
    return Voxels(origin_mm=tuple(origin.tolist()), size_mm=tuple(edge.tolist()), counts=(x, y, z))


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
        values, slopes, centres = (floats(each) for each in elements)
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
    steps: int = 1
    """Points along a ray that its light is taken from: a random one, or so many even ones."""

    def along(self, ray: Any, begin: Any, kept: Any, sigma_t: Any, sample: Any, active: Any) -> Any:
        """Mean over the collisions of a ray in the voxels' medium; a uniform sample decides where one point is."""
        samples = [sample] if self.steps == 1 else [(step + 0.5) / self.steps for step in range(self.steps)]
        values = [self.at(ray(begin + free_path(each, kept, sigma_t)), active) for each in samples]
        return values[0] if self.steps == 1 else sum(values[1:], values[0]) / self.steps

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


def cell_elements(fluence: Array, centres_mm: Array | None, counts: tuple[int, int, int]) -> Elements:
    """Light in the cells, see `cell_slopes`; without a grid there is one of them, which holds none."""
    if centres_mm is None:
        return Elements(fluence, np.zeros((1, AXES, 3)), np.zeros((1, AXES)))
    return Elements(fluence, cell_slopes(fluence, centres_mm, counts), centres_mm)


def body_elements(light: Array, part: BodyPart, voxels: Voxels) -> Elements:
    """Light in the voxels of a body [mm3], with slopes between the LED strips."""
    held = part.held_mm3[:, None]
    fluence = np.divide(light, held, out=np.zeros_like(light), where=held > 0)
    slopes, inner = np.zeros((len(fluence), AXES, 3)), voxels.inner
    slopes[inner] = cell_slopes(fluence[inner], part.centres_mm[inner], voxels.inner_counts)
    return Elements(fluence, slopes, part.centres_mm)


def cell_slopes(fluence: Array, centres: Array, counts: tuple[int, int, int]) -> Array:
    """Slopes of the fluence in each cell, by differences between its neighbours' means, (cells, 3 axes, 3) [1/mm].

    A fluence of constant cells is wrong by its change across a cell, 2 % beside the LEDs; a linear one by its
    curvature. The difference of neighbours is nearly free of the noise that a fit inside the cell would have. At the
    rim of the grid it is one-sided; along an axis with a single cell there is none.
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
