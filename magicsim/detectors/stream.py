"""The detectors as a stream: the first frames make the references, every later one gets a verdict.

Two pure functions, `start_stream` and `step_stream`, and the state between them, so that a robot's loop can hold, copy
or replay it. A batch (`fuse` on the first frames, `detect_all` on the rest) gives the same verdicts.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy.typing as npt

from magicsim.detectors.combined import detect
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.verdict import Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamState:
    """All that the detectors remember between two frames."""

    waiting: tuple[Frame, ...] = ()
    """Copies of the reference frames so far; empty once they are fused."""
    references: References | None = None
    """The references; None until `profile.reference_count` frames have come."""


def start_stream(references: References | None = None) -> StreamState:
    """The state before the first frame; with references from `fuse` every frame gets a verdict at once."""
    return StreamState(references=references)


def step_stream(
    state: StreamState, frame: npt.ArrayLike, profile: DetectorProfile, *, source: str | None = None
) -> tuple[StreamState, Verdict | None]:
    """Take one frame.

    The state that is passed in stays valid, so that a frame that raises can be left out of the stream.

    Args:
        state: From `start_stream` or the step before.
        frame: RGB image, uint8, shape (rows, columns, 3); copied where it is kept, as a camera may write over it.
        profile: Thresholds and options, the same for every step.
        source: Where the frame came from, kept in the verdict.

    Returns:
        The next state, and the verdict; None for a frame that went into the references.

    Raises:
        FrameError: The frame is not an image of the references' size, or the references show no grid.
        ConfigError: The references were fused with other options than the profile's.
    """
    if state.references is not None:
        return state, detect(frame, state.references, profile, source=source)
    shape = state.waiting[0].shape if state.waiting else None
    waiting = (*state.waiting, check_frame(frame, shape=shape).copy())
    if len(waiting) < profile.reference_count:
        return StreamState(waiting=waiting), None
    return StreamState(references=fuse(waiting, profile)), None


def detect_from_start(frames: Iterable[npt.ArrayLike], profile: DetectorProfile) -> Iterator[Verdict]:
    """Verdicts of a stream after its first `profile.reference_count` frames, which show the untouched sensor.

    Raises:
        FrameError: As `step_stream`, at the frame that is wrong.
    """
    state = start_stream()
    for frame in frames:
        state, verdict = step_stream(state, frame, profile)
        if verdict is not None:
            yield verdict
