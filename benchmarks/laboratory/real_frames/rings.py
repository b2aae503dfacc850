"""A model of the rings of light, smooth in constants and depth, from renderings."""

import numpy as np

from laboratory.real_frames.constants import DEPTH_MM, GAPS_MM, RANGES, Constants
from magicsim.arrays import Array


class Rings:
    """Smooth rings of radiance over constants and depth, from renderings."""

    def __init__(self, points: Array, renders: Array) -> None:
        """Fits the logarithms.

        Args:
            points: Rendered constants, shape (points, 4).
            renders: Rings, shape (points, 5, rings).
        """
        basis = np.array([self._basis(point) for point in points])
        self.rest, *_ = np.linalg.lstsq(basis, np.log(renders[:, 0]), rcond=None)
        depths = np.array([self._depths(-gap) for gap in GAPS_MM])
        both = np.einsum("pb,gd->pgbd", basis, depths).reshape(len(points) * len(GAPS_MM), -1)
        ratio = np.log(renders[:, 1:] / renders[:, :1]).reshape(len(both), -1)
        self.change, *_ = np.linalg.lstsq(both, ratio, rcond=None)
        self.correction = np.ones((2, renders.shape[2]))

    @staticmethod
    def _basis(point: Array) -> Array:
        low, high = np.array(list(RANGES.values())).T
        s, a, c, r = (2 * point - low - high) / (high - low)
        return np.array([1, s, s * s, a, s * a, c, c * c, s * c, r, s * r])

    @staticmethod
    def _depths(depth_mm: float) -> Array:
        u = (depth_mm - np.mean(DEPTH_MM)) / np.ptp(DEPTH_MM) * 2
        return np.array([1, u, u * u])

    def of(self, constants: Constants) -> tuple[Array, Array]:
        """Untouched and pressed radiance in rings."""
        basis = self._basis(constants.rendered)
        rest = np.exp(basis @ self.rest)
        change = np.exp(np.outer(basis, self._depths(constants.depth_mm)).ravel() @ self.change)
        return rest * self.correction[0], rest * change * self.correction[1]

    def correct(self, constants: Constants, rendered: Array) -> None:
        """Goes through a rendering from now on, untouched and pressed, shape (2, rings); its neighbours move along."""
        self.correction = self.correction * rendered / np.array(self.of(constants))
