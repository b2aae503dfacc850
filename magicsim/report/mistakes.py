"""Which verdicts are wrong, by the same rules as the score."""

from collections.abc import Sequence
from dataclasses import dataclass

from magicsim.detectors.verdict import Contact, Verdict
from magicsim.frame_class import FrameClass
from magicsim.judge.score import PROXIMITY_TRUTH
from magicsim.report.runs import runs
from magicsim.simulation.episode import SimulatedFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Mistake:
    """Neighbouring frames of one class with the same wrong verdict."""

    first: int
    """Place of the first frame in the stream."""
    last: int
    """Place of the last frame in the stream."""
    truth: str
    """Class of the frames."""
    verdict: str
    """What was said of them."""


def proximity_right(verdict: Verdict, truth: FrameClass | None) -> bool | None:
    """Whether the proximity verdict is right; None where proximity is not scored."""
    if truth is None or truth not in PROXIMITY_TRUTH:
        return None
    return verdict.proximity is PROXIMITY_TRUTH[truth]


def contact_right(verdict: Verdict, truth: FrameClass | None) -> bool | None:
    """Whether the combined verdict is right; None where the frame is not scored."""
    if truth is None:
        return None
    return (verdict.combined is Contact.TOUCHED) == (truth is FrameClass.CONTACT)


def list_mistakes(frames: Sequence[SimulatedFrame], verdicts: Sequence[Verdict]) -> list[Mistake]:
    """All wrong verdicts, proximity first, with neighbouring equal ones taken together.

    Args:
        frames: The scored frames.
        verdicts: One for each frame.
    """
    classes = [frame.truth.frame_class for frame in frames]
    pairs = list(zip(verdicts, classes, strict=True))
    near = [(each, one.proximity) if proximity_right(one, each) is False else None for one, each in pairs]
    touch = [(each, one.combined) if contact_right(one, each) is False else None for one, each in pairs]
    return [
        Mistake(
            first=frames[run.start].truth.index,
            last=frames[run.stop - 1].truth.index,
            truth=str(run.value[0]),
            verdict=str(run.value[1]),
        )
        for told in (near, touch)
        for run in runs(told)
        if run.value is not None
    ]
