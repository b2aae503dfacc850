"""What the network of a touch sees: fields that physics gives, as images of the camera.

    warp     what the untouched image changes by when one plane of the lattice takes it along, for some planes
    rest     the untouched image
    object   what the object and the room behind it change of it just before contact
    mask     where the face touches the object
    shift    displacements of some planes

The first four have the camera's resolution, and every 2 x 2 pixels become channels of their own; the shifts have half
of it. Radiance is in units of the mean of the untouched image. A change is the network's answer times a gate, which is
0 where nothing has moved: a touch of no depth changes nothing, whatever the network says.
"""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage, Mask
from magicsim.camera.projection import pixel_landing_mm
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

Fields = npt.NDArray[np.float32]
"""Shape (channels, rows / 2, columns / 2)."""
SHIFT_HEIGHTS, WARP_HEIGHTS = (0.0, 0.12, 0.5, 0.88), (0.12, 0.5, 0.88)
"""Heights of planes whose displacement is seen, and that take the image along, in parts of the block's height: the
nearest planes of the lattice serve. 0.12 is where the skin of the default design ends and the grid begins."""
STEP_MM = 0.05
"""Height over which it is found how a pixel's place moves with height [mm]."""
SHIFT_UNIT_MM = 0.3
"""Unit of displacements that the network sees [mm]: that of a press of some tenths of a millimetre."""
GATE_MM, CONTACT_MM, GATE_PX = 0.02, 0.1, 3.0
"""Displacement at which the gate is half open [mm], what contact counts for [mm], and the width of its mean [px]."""
STILL_MM = 0.001
"""Displacement up to which nothing changes, as in the true tier, and from twice which the gate is as wide as it is."""
MULTIPLE = 8
"""Rows and columns of fields are filled up to multiples of it: the network halves them three times."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Plane:
    """How pixels see one plane of the lattice."""

    number: int
    column: npt.NDArray[np.float32]
    """Which node each pixel looks at, along x, in parts of a step, shape (rows, columns)."""
    row: npt.NDArray[np.float32]
    """Along y."""
    slope: npt.NDArray[np.float32]
    """How far a pixel's place moves in x and y for each millimetre of height, shape (rows, columns, 2)."""
    pixel_mm: tuple[float, float]
    """What a step to the next column and to the next row is along x and y [mm]."""
    is_seen: bool
    is_warp: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldMaker:
    """Makes the fields of one sensor's touches."""

    rest: FloatImage
    """Radiance of the untouched sensor, shape (rows, columns, 3)."""
    scale: float
    """Mean of that radiance."""
    order: npt.NDArray[np.int64]
    """Lattice nodes plane by plane, row by row."""
    shape: tuple[int, int, int]
    """Nodes along z, y and x."""
    planes: tuple[_Plane, ...]

    @classmethod
    def of(cls, design: ElastomerDesign, rig: Rig, nodes_mm: Array, rest: FloatImage) -> Self:
        """For a sensor.

        Args:
            design: The block.
            rig: Lens and camera.
            nodes_mm: Nodes of the design's lattice at rest, shape (nodes, 3) [mm].
            rest: Radiance of the untouched sensor, shape (rows, columns, 3), both even.
        """
        x, y, z = (np.unique(np.round(nodes_mm[:, axis], 5)) for axis in range(3))
        seen, warp = (
            {_nearest(z, share * design.height_mm) for share in each} for each in (SHIFT_HEIGHTS, WARP_HEIGHTS)
        )
        planes = []
        for number in sorted(seen | warp):
            place, above = (
                pixel_landing_mm(design, rig.lens, rig.camera, z_mm=float(z[number]) + step) for step in (0.0, STEP_MM)
            )
            planes.append(
                _Plane(
                    number=number, column=_between(place[..., 0], x), row=_between(place[..., 1], y),
                    slope=((above - place) / STEP_MM).astype(np.float32),
                    pixel_mm=(
                        float(np.diff(place[..., 0], axis=1).mean()), float(np.diff(place[..., 1], axis=0).mean())
                    ),
                    is_seen=number in seen, is_warp=number in warp,
                )
            )  # fmt: skip
        return cls(
            rest=rest.astype(np.float32), scale=float(rest.mean()),
            order=np.lexsort((nodes_mm[:, 0], nodes_mm[:, 1], nodes_mm[:, 2])), shape=(len(z), len(y), len(x)),
            planes=tuple(planes),
        )  # fmt: skip

    def make(
        self, displacements_mm: npt.NDArray[np.float32], free: FloatImage, mask: Mask
    ) -> tuple[Fields, npt.NDArray[np.float32]]:
        """Fields of one touch, and the gate of its change, shape (rows, columns), from 0 to 1.

        Args:
            displacements_mm: Of the lattice's nodes, shape (nodes, 3) [mm].
            free: Radiance with the object just before contact, shape (rows, columns, 3).
            mask: Where the face touches, shape (rows, columns).
        """
        moved = displacements_mm[self.order].reshape(*self.shape, 3).astype(np.float32)
        contact, rest = mask.astype(np.float32), self.rest / self.scale
        fine, coarse, size_mm = [], [], CONTACT_MM * contact
        for plane in self.planes:
            level = np.ascontiguousarray(moved[plane.number])
            shift = np.asarray(
                cv2.remap(level, plane.column, plane.row, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32
            )
            np.maximum(size_mm, np.sqrt(np.einsum("rci,rci->rc", shift, shift)), out=size_mm)
            if plane.is_warp:
                fine.append(self._taken_along(rest, plane, shift) - rest)
            if plane.is_seen:
                coarse.append(np.asarray(sum(_corners(shift))) / (4 * SHIFT_UNIT_MM))
        fine += [rest - 1, (free - self.rest) / self.scale, contact[..., None]]
        size_mm = np.asarray(cv2.GaussianBlur(size_mm, (0, 0), GATE_PX), np.float32)
        fields = np.concatenate([_folded(np.concatenate(fine, -1)), *(each.transpose(2, 0, 1) for each in coarse)])
        moves = np.clip(size_mm / STILL_MM - 1, 0, 1)
        return fields.astype(np.float32), np.asarray(moves * size_mm / (size_mm + GATE_MM), np.float32)

    def _taken_along(self, image: FloatImage, plane: _Plane, shift: npt.NDArray[np.float32]) -> FloatImage:
        """An image moved as a plane is, seen from the camera: what rises moves as if it went aside."""
        aside = shift[..., :2] - plane.slope * shift[..., 2:]
        row, column = np.indices(image.shape[:2], np.float32)
        places = (column - aside[..., 0] / plane.pixel_mm[0], row - aside[..., 1] / plane.pixel_mm[1])
        return np.asarray(cv2.remap(image, *places, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mirror:
    """Another sensor that is as good as this one: left is right or up is down; colours go with the lights."""

    axis: int
    """0 across columns, 1 across rows."""
    channels: tuple[int, int, int] = (0, 1, 2)
    """Which colour each becomes."""

    def image(self, image: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """An image or a gate, shape (colours or 1, rows, columns)."""
        flipped = np.flip(image, 2 - self.axis)
        return flipped[list(self.channels)] if len(image) == len(self.channels) else flipped

    def fields(self, fields: Fields) -> Fields:
        """Fields of the mirrored touch."""
        images, colours = 4 * (3 * (len(WARP_HEIGHTS) + 2) + 1), list(self.channels)
        rows, columns = fields.shape[1:]
        fine = np.flip(fields[:images].reshape(-1, 2, 2, rows, columns), (2 - self.axis, 4 - self.axis)).copy()
        groups = fine[:-1].reshape(-1, 3, 2, 2, rows, columns)[:, colours]
        shifts = np.flip(fields[images:].reshape(-1, 3, rows, columns), 3 - self.axis).copy()
        shifts[:, self.axis] *= -1
        parts = (
            groups.reshape(-1, rows, columns),
            fine[-1].reshape(-1, rows, columns),
            shifts.reshape(-1, rows, columns),
        )
        return np.concatenate(parts)


def mirrors_of(rig: Rig) -> tuple[Mirror, ...]:
    """Mirrors under which a rig with a flat, even block is another one of its kind."""
    camera = rig.camera
    if rig.leds or rig.ring is not None or any(camera.principal_offset_px) or any(camera.distortion[2:4]):
        return ()
    strips = {each.side: (tuple(value > 0 for value in each.radiance), each.coupling, each.margin_mm, each.reflectance)
              for each in rig.strips}  # fmt: skip
    found = []
    for axis, name in enumerate("xy"):
        swapped = {side: side.translate(str.maketrans("+-", "-+")) if side[1] == name else side for side in strips}
        for channels in ((0, 1, 2), (2, 1, 0)):
            here = {
                swapped[side]: (tuple(each[0][place] for place in channels), *each[1:]) for side, each in strips.items()
            }
            if here == strips:
                found.append(Mirror(axis=axis, channels=channels))
                break
    return tuple(found)


def filled(fields: Fields) -> Fields:
    """Fields with rows and columns repeated at the end until the network can halve them."""
    missing = [-size % MULTIPLE for size in fields.shape[1:]]
    return np.pad(fields, ((0, 0), (0, missing[0]), (0, missing[1])), mode="edge") if any(missing) else fields


def _nearest(values: Array, wanted: float) -> int:
    return int(np.argmin(np.abs(values - wanted)))


def _between(places: Array, nodes: Array) -> npt.NDArray[np.float32]:
    return np.interp(places, nodes, np.arange(len(nodes))).astype(np.float32)


def _folded(image: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Every 2 x 2 pixels as channels, shape (4 channels, rows / 2, columns / 2)."""
    parts = np.stack(_corners(image)).transpose(3, 0, 1, 2)
    return np.ascontiguousarray(parts.reshape(-1, *parts.shape[2:]))


def _corners(image: npt.NDArray[np.float32]) -> list[npt.NDArray[np.float32]]:
    """Four images: of every 2 x 2 pixels the first, that to its right, that below, and the last."""
    return [image[row::2, column::2] for row, column in np.ndindex(2, 2)]
