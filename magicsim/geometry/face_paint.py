"""Colour and opacity of the contact face, as a picture over the undeformed face: coat and markers in one."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.coat import OpaqueCoat
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.markers import DotMarkers, PictureMarkers

PIXELS_PER_DIAMETER = 24
FINEST_MM = 0.01
"""Pixels are not finer than this [mm]: a tenth of what a camera pixel covers."""
MOST_PIXELS = 4_000_000
TINY = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class FacePaint:
    """The opaque part of a face; the rest is bare, or behind a film."""

    texels: Array
    """Diffuse reflectance in linear RGB and opacity, shape (rows, columns, 4), rows along +y, columns along +x."""
    origin_mm: tuple[float, float]
    """Place of the outer corner of the first texel, x and y [mm]."""
    pixel_mm: float
    """Edge of a texel [mm]."""


def face_paint(design: ElastomerDesign) -> FacePaint | None:
    """The paint of a design's face; None where it is bare or has a film alone.

    Edges of dots rise over the width of one texel, so that they have no steps.
    """
    ground = (*design.coat.color, 1.0) if isinstance(design.coat, OpaqueCoat) else (0.0, 0.0, 0.0, 0.0)
    size, markers = np.array(design.footprint_mm), design.markers
    if markers is None or markers.depth_mm > 0:
        if ground[3] == 0:
            return None
        texels = np.array(ground).reshape(1, 1, 4)
        return FacePaint(texels=texels, origin_mm=(-size[0] / 2, -size[1] / 2), pixel_mm=float(size.max()))
    if isinstance(markers, DotMarkers):
        return _dotted(markers, size, np.array(ground))
    return _printed(markers, size, np.array(ground))


def _dotted(markers: DotMarkers, size: Array, ground: Array) -> FacePaint:
    from scipy.spatial import cKDTree

    pixel = max(markers.diameter_mm / PIXELS_PER_DIAMETER, _finest_mm(size))
    columns, rows = (int(count) for count in np.ceil(size / pixel))
    x, y = (
        np.arange(count) * pixel + pixel / 2 - extent / 2 for count, extent in zip((columns, rows), size, strict=True)
    )
    places = np.stack(np.meshgrid(x, y), -1)
    reach = markers.diameter_mm / 2 + pixel
    far, _ = cKDTree(markers.centres_mm((size[0], size[1]))).query(places, distance_upper_bound=reach)
    share = np.clip((markers.diameter_mm / 2 - np.minimum(far, reach)) / pixel + 0.5, 0, 1)[..., None]
    return FacePaint(
        texels=_over(share, np.array(markers.color), ground), origin_mm=(-size[0] / 2, -size[1] / 2), pixel_mm=pixel
    )


def _printed(markers: PictureMarkers, size: Array, ground: Array) -> FacePaint:
    pixels, finest = markers.pixels()[::-1], _finest_mm(size)
    if markers.width_mm / pixels.shape[1] < finest:
        pixels = _coarser(pixels, max(1, int(markers.width_mm / finest)))
    pixel = markers.width_mm / pixels.shape[1]
    columns, rows = (int(np.ceil(extent / pixel)) + 2 for extent in size)
    texels = np.tile(ground, (rows, columns, 1))
    row, column = ((whole - part) // 2 for whole, part in zip((rows, columns), pixels.shape, strict=False))
    there = np.s_[row : row + pixels.shape[0], column : column + pixels.shape[1]]
    texels[there] = _over(pixels[..., 3:], pixels[..., :3], ground)
    origin = (-markers.width_mm / 2 - column * pixel, -pixels.shape[0] * pixel / 2 - row * pixel)
    return FacePaint(texels=texels, origin_mm=origin, pixel_mm=pixel)


def _finest_mm(size: Array) -> float:
    return max(FINEST_MM, float(np.sqrt(np.prod(size) / MOST_PIXELS)))


def _coarser(pixels: Array, columns: int) -> Array:
    """Means of a picture over larger pixels, colours weighted by their opacity."""
    import cv2

    rows = max(1, round(pixels.shape[0] * columns / pixels.shape[1]))
    weighted = np.concatenate([pixels[..., :3] * pixels[..., 3:], pixels[..., 3:]], -1)
    means = cv2.resize(weighted, (columns, rows), interpolation=cv2.INTER_AREA)
    return np.concatenate([means[..., :3] / np.maximum(means[..., 3:], TINY), means[..., 3:]], -1)


def _over(share: Array, color: Array, ground: Array) -> Array:
    """A colour laid over the ground; where the ground is bare the colour alone goes on, at the share's opacity."""
    opacity = share + (1 - share) * ground[3]
    mixed = share * color + (1 - share) * ground[:3] if ground[3] > 0 else color + np.zeros_like(share)
    return np.concatenate([mixed, opacity], -1)
