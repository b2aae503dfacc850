"""How much of the light at a place comes from where something touches: what a contact can change of it at most.

Light that leaves a small patch of the face in all directions alike brings a place the patch's solid angle there over
that of a hemisphere, if light otherwise comes alike from all around. A contact replaces what a bare face sends back by
what the object does, so the share is about the largest relative change, and far from a small contact it is next to
nothing. It serves as the expected size of a change that is measured with noise (`anchored_light`), not as the change.
"""

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.kernels import kernel

PATCHES = 200
"""Patches that a contact is taken as, about."""


def contact_share(places_mm: Array, vertices_mm: Array, faces: npt.NDArray[np.int32]) -> Array:
    """Solid angle of a contact over 2 pi, at most 1, shape (places,).

    Args:
        places_mm: Shape (places, 3), in the sensor's frame [mm].
        vertices_mm: The object's vertices, shape (vertices, 3) [mm].
        faces: Its triangles that touch, shape (triangles, 3).
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
