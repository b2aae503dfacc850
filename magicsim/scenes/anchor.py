"""The untouched sensor that the frames of an episode refer to."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.scenes.light_field import LightField

FloatImage = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Anchor:
    """The untouched sensor, rendered cheaply with a seed and once with care.

    A frame with the same seed differs from the cheap rendering only where something changed, so what the cheap image
    differs by from the careful one can be taken off as far as frames share it (see `anchored_image`). The
    fluence behind it is the careful one times a change of local means (see `anchored_light`): far less noisy, and
    biased only where light changes within a few cells. The careful state has a seed of its own, the same for every
    episode: an untouched sensor always looks the same.
    """

    cheap: dict[str, LightField]
    careful: dict[str, LightField]
    cheap_image: FloatImage
    image: FloatImage
    held_mm3: npt.NDArray[np.float64]
    """Volume of the body in each voxel, shape (voxels, 1); 1 where the body is clear."""
