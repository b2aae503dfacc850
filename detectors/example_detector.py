"""A detector of one's own, judged like the built-in ones. It needs NumPy alone.

    magicsim evaluate --detector detectors/example_detector.py:ChangedPixels

It counts pixels that leave the noise of the references. An object in front only adds light, so pixels *brighten*; a
press moves dark walls over bright cells, so pixels *darken*; a flashlight brightens most of the picture at once.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from magicsim.evaluation.detector import Detection

Frame = npt.NDArray[np.uint8]
DEVIATIONS = 6.0
"""Standard deviations of the references beyond which a pixel has changed."""
NEAR_SHARE = 0.02
"""Share of brightened pixels from which something is near."""
LIGHT_LEVELS = 12.0
"""Mean brightening of the dark walls [grey levels] from which light comes from outside: walls hide an object."""
TOUCH_SHARE = 0.01
"""Share of darkened pixels from which something touches."""


class ChangedPixels:
    """Shares of brightened and darkened pixels; made anew, without arguments, for every episode."""

    def fit(self, references: Sequence[Frame]) -> None:
        """Learns mean and noise of every pixel from the untouched sensor, frames of shape (rows, columns, 3)."""
        stack = np.stack(references).astype(np.float64)
        self.mean = stack.mean(axis=0)
        self.noise = np.maximum(stack.std(axis=0), 0.5)  # rounding to 8 bit hides smaller noise
        self.walls = self.mean <= np.quantile(self.mean, 0.2, axis=(0, 1))

    def step(self, frame: Frame) -> Detection:
        """Judges the next frame, shape (rows, columns, 3)."""
        change = frame - self.mean
        brightened = float((change > DEVIATIONS * self.noise).mean())
        darkened = float((change < -DEVIATIONS * self.noise).mean())
        is_light = float(change[self.walls].mean()) > LIGHT_LEVELS
        is_near = brightened > NEAR_SHARE
        proximity = "Noise" if is_light else "Approaching" if is_near else "Normal"
        contact = "Touched" if darkened > TOUCH_SHARE else "Untouched"
        return Detection(
            proximity=proximity,
            contact="Unknown" if is_light else contact,
            approach=0.0 if is_light else brightened,
            touch=0.0 if is_light else darkened,
        )
