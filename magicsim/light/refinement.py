"""The mean of independent images, and how large its error is, by their own spread."""

from dataclasses import dataclass, field

import numpy as np

from magicsim.arrays import Array, FloatImage

LEAST_PASSES = 4
"""Images below which their spread says little: with four the estimate is within some per cent, over so many pixels."""
MAX_PASSES = 4096
BORDER_PX, BORDER_SHARE = 30, 4
"""Edge that the error leaves out: so many pixels, or one in so many of a small image."""


@dataclass(slots=True)
class Refinement:
    """Images so far; the error is that of their mean.

    The error is the root mean square over pixels and channels of the central image, over the mean there. It knows what
    changes from image to image, noise and aliasing, but no bias that all of them share.
    """

    passes: int = 0
    _sum: Array = field(default_factory=lambda: np.zeros(0))
    _squares: Array = field(default_factory=lambda: np.zeros(0))

    def add(self, image: FloatImage) -> None:
        """Takes one more image, shape (rows, columns, 3)."""
        now = image.astype(np.float64)
        self._sum, self._squares = (now, now**2) if self.passes == 0 else (self._sum + now, self._squares + now**2)
        self.passes += 1

    @property
    def image(self) -> FloatImage:
        """The mean, shape (rows, columns, 3)."""
        return np.asarray(self._sum / self.passes, np.float32)

    @property
    def relative_error(self) -> float:
        """Relative error of the mean; infinite before there is any spread to judge it by."""
        if self.passes < LEAST_PASSES:
            return float("inf")
        mean = self._sum / self.passes
        variance = (self._squares / self.passes - mean**2) / (self.passes - 1)
        size = float(central(mean).mean())
        return float(np.sqrt(max(central(variance).mean(), 0.0))) / size if size > 0 else 0.0

    def is_within(self, relative_error: float) -> bool:
        """Whether the mean is as good as asked for."""
        return self.relative_error <= relative_error


def central(image: Array) -> Array:
    """The image without its edges."""
    cut = [min(BORDER_PX, size // BORDER_SHARE) for size in image.shape[:2]]
    return image[cut[0] : image.shape[0] - cut[0], cut[1] : image.shape[1] - cut[1]]
