"""Light as the light pass leaves it: fluence in the cells, irradiance on the object. Linear in the lights."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class LightField:
    """What one light, or several together, bring into the scene."""

    fluence: Array
    """Fluence of each cell and channel, shape (cells, 3)."""
    body: Array
    """Fluence of the body times what each voxel holds of it, shape (voxels, 3) [mm3]; one voxel where it is clear."""
    irradiance: Array
    """Irradiance of each of the object's triangles and channel, shape (triangles, 3)."""


def total(fields: Sequence[LightField]) -> LightField:
    """Sum over lights."""
    return LightField(
        fluence=np.sum([field.fluence for field in fields], axis=0),
        body=np.sum([field.body for field in fields], axis=0),
        irradiance=np.sum([field.irradiance for field in fields], axis=0),
    )
