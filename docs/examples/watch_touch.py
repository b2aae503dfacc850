"""Watches a touch sensor through OpenCV: the same code on a camera and on the simulator.

python docs/examples/watch_touch.py            # the simulator: a ball comes, presses, shears and leaves
python docs/examples/watch_touch.py 0          # camera number 0, untouched for its first 30 frames
"""

import sys
from typing import Protocol

import cv2
import numpy as np

from magicsim.detectors import DetectorProfile, Frame, Verdict, detect, fuse, load_profile
from magicsim.robot import LiveSensor, SimulatedCapture, Workspace, live_sensor

REFERENCE_S = 2.0
"""Time for which nothing comes near [s]: 30 frames at 15 frames a second."""
TIMES_S, GAPS_MM, XS_MM = (0, 1, 1.5, 2), (6, -1.2, -1.2, 6), (0, 0, 1, 1)
"""Way of the ball in the simulator, from the end of the references."""


class Capture(Protocol):
    """What is used of `cv2.VideoCapture`."""

    def read(self) -> tuple[bool, Frame | None]:
        """Whether there is a frame, and the frame in BGR."""


def watch(capture: Capture, *, frames: int, profile: DetectorProfile) -> list[Verdict]:
    """Learns the untouched sensor from the first frames, then judges the ones that follow.

    Args:
        capture: A `cv2.VideoCapture`, or something that reads alike.
        frames: How many to judge.
        profile: Of the detectors.
    """
    references = fuse([next_frame(capture) for _ in range(profile.reference_count)], profile)
    return [detect(next_frame(capture), references, profile) for _ in range(frames)]


def next_frame(capture: Capture) -> Frame:
    """The next frame, turned from OpenCV's BGR to the RGB that the detectors take."""
    is_read, frame = capture.read()
    if not is_read or frame is None:
        sys.exit("the camera gives no frame")
    return cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)


def touch(sensor: LiveSensor, time_s: float) -> None:
    """A world to watch: after the references a ball comes from 6 mm, presses 1.2 mm deep, shears, and leaves."""
    since = time_s - REFERENCE_S
    if since >= 0:
        gap, x = (float(np.interp(since, TIMES_S, values)) for values in (GAPS_MM, XS_MM))
        sensor.move_to(gap_mm=gap, x_mm=x)


def main() -> None:
    """Watches 30 frames and writes a line for each."""
    profile = load_profile("calibrated")
    if len(sys.argv) > 1:
        capture = cv2.VideoCapture(int(sys.argv[1]))
    else:
        capture = SimulatedCapture(live_sensor("demo", workspace=Workspace(twist_deg=(0, 0))), world=touch)
    for number, verdict in enumerate(watch(capture, frames=30, profile=profile)):
        sys.stdout.write(f"{number:3d}  {verdict.proximity:12s} {verdict.combined:10s} S = {verdict.similarity:.2f}\n")
    capture.release()


if __name__ == "__main__":
    main()
