"""A detector of your own, scored on a simulated episode like the published ones.

It calls a frame touched where its brightness differs from the untouched sensor's anywhere by much more than noise.

python docs/examples/your_detector.py      # its accuracy beside the published detectors', two minutes
"""

from collections.abc import Sequence

import cv2
import numpy as np

from magicsim import load_scene, simulate
from magicsim.detectors import Contact, Frame, Proximity, Verdict, detect_all, fuse, load_profile, score_verdicts
from magicsim.simulation.episode import Episode

BLUR_PX = 9
"""Side of the kernel that suppresses pixel noise [px]."""


class LargestChange:
    """Learns the mean of untouched frames; judges by the largest change of the blurred grey image."""

    def __init__(self, untouched: Sequence[Frame], *, threshold: float = 12.0) -> None:
        """Takes frames of the untouched sensor, each (rows, columns, 3), and a threshold in grey levels."""
        self.reference = np.mean([_grey(frame) for frame in untouched], axis=0)
        self.threshold = threshold

    def change(self, frame: Frame) -> float:
        """Largest change of a frame [grey levels]."""
        return float(np.abs(_grey(frame) - self.reference).max())

    def judge(self, frame: Frame) -> Verdict:
        """The verdict on one frame; it says nothing about proximity."""
        change = self.change(frame)
        contact = Contact.TOUCHED if change > self.threshold else Contact.UNTOUCHED
        return Verdict(
            entropy=0.0, correlation=0.0, similarity=0.0, p_approach=0.0, p_noise=0.0,
            p_touch=change / (change + self.threshold), proximity=Proximity.NORMAL, contact=contact, combined=contact,
        )  # fmt: skip


def _grey(frame: Frame) -> np.ndarray:
    blurred = cv2.GaussianBlur(frame, (BLUR_PX, BLUR_PX), 0)
    return np.asarray(cv2.cvtColor(blurred, cv2.COLOR_RGB2GRAY), np.float64)


def contact_accuracies(episode: Episode) -> tuple[float | None, float | None]:
    """Balanced accuracy of contact: this detector's, and that of the profile `calibrated`."""
    untouched = [frame.image for frame in episode.references]
    images = [frame.image for frame in episode.scored]
    classes = [frame.truth.frame_class for frame in episode.scored]
    own = LargestChange(untouched)
    profile = load_profile("calibrated")
    theirs = detect_all(images, fuse(untouched, profile), profile)
    return (
        score_verdicts([own.judge(image) for image in images], classes).contact.accuracy,
        score_verdicts(theirs, classes).contact.accuracy,
    )


if __name__ == "__main__":
    print(contact_accuracies(simulate(load_scene("demo"))))
