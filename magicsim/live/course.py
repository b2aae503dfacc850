"""The recent course of the force."""

from collections import deque

import numpy as np
import numpy.typing as npt

KEPT = 200
"""Steps that are remembered."""


class Course:
    """Normal and tangential force of the last steps."""

    def __init__(self) -> None:
        """Without any."""
        self._steps: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._first = 0

    def add(self, force_n: tuple[float, float, float]) -> None:
        """Takes the force of the object on the sensor [N]."""
        self._first += len(self._steps) == KEPT
        x, y, z = force_n
        self._steps.append((z, float(np.hypot(x, y))))

    def columns(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Number of each step, its normal force and its tangential force [N], each of shape (steps,); two at least."""
        steps = list(self._steps) or [(0.0, 0.0)]
        steps = steps if len(steps) > 1 else [steps[0], steps[0]]
        normal, tangential = np.array(steps).T
        return np.arange(self._first, self._first + len(steps), dtype=float), normal, tangential
