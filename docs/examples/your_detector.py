"""A detector of your own, with the two methods that `magicsim evaluate --detector` asks for.

It calls a frame touched where its brightness differs from the untouched sensor's anywhere by much more than noise.

    python docs/examples/your_detector.py      # its accuracy beside the published detectors', two minutes
    magicsim evaluate small --detector docs/examples/your_detector.py:LargestChange
"""

from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np
import numpy.typing as npt

from magicsim import load_profile, load_scene, simulate
from magicsim.evaluation.detector import Detection, MakeDetector, ProfileDetector
from magicsim.simulation.episode import Episode

Frame = npt.NDArray[np.uint8]
BLUR_PX = 9
"""Side of the kernel that suppresses pixel noise [px]."""


class LargestChange:
    """Learns the mean of untouched frames; judges by the largest change of the blurred grey image."""

    def __init__(self, threshold: float = 12.0) -> None:
        """Takes a threshold [grey levels]; everything has a default, since `evaluate` makes it without arguments."""
        self.threshold = threshold
        self.reference = np.zeros((0, 0))

    def fit(self, references: Sequence[Frame]) -> None:
        """Learns the untouched sensor, frames of shape (rows, columns, 3)."""
        self.reference = np.mean([_grey(frame) for frame in references], axis=0)

    def change(self, frame: Frame) -> float:
        """Largest change of a frame [grey levels]."""
        return float(np.abs(_grey(frame) - self.reference).max())

    def step(self, frame: Frame) -> Detection:
        """Judges the next frame; it says nothing about what is near, so its score of that is always the same."""
        change = self.change(frame)
        contact = "Touched" if change > self.threshold else "Untouched"
        return Detection(proximity="Normal", contact=contact, approach=0.0, touch=change)


def _grey(frame: Frame) -> npt.NDArray[np.float64]:
    blurred = cv2.GaussianBlur(frame, (BLUR_PX, BLUR_PX), 0)
    return np.asarray(cv2.cvtColor(blurred, cv2.COLOR_RGB2GRAY), np.float64)


def contact_accuracy(episode: Episode, make: MakeDetector) -> float:
    """Mean of the shares of touched and of untouched frames that a detector calls right."""
    detector = make()
    detector.fit([frame.image for frame in episode.references])
    scored = [frame for frame in episode.scored if frame.truth.frame_class is not None]
    called = np.array([detector.step(frame.image).contact == "Touched" for frame in scored])
    touched = np.array([frame.truth.frame_class == "Contact" for frame in scored])
    return float((called[touched].mean() + (~called[~touched]).mean()) / 2)


if __name__ == "__main__":
    demo = simulate(load_scene("demo"))
    theirs = partial(ProfileDetector, load_profile("calibrated"))
    print(contact_accuracy(demo, LargestChange), contact_accuracy(demo, theirs))
