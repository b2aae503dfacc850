"""Contact sheet: the frames that tell an episode's story, and what stands below them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import FrameClass
from magicsim.report.mistakes import contact_right, proximity_right
from magicsim.report.runs import Run, runs
from magicsim.report.story import Phase, tell_phases
from magicsim.report.text import gap_or_depth, quantity
from magicsim.simulation.episode import SimulatedFrame

SHEET_FRAMES = 18
"""Largest number of frames on a contact sheet."""

Scene = Run[tuple[Phase, FrameClass | None]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """What stands below one frame."""

    index: int
    """Place of the frame in the stream."""
    phase: str
    """Part of the story."""
    distance: str
    """Gap or depth."""
    force: str
    """Magnitude of the contact force."""
    truth: str
    """Class, or that the frame is not scored."""
    proximity: str | None
    """Proximity verdict; None without a judgement."""
    proximity_right: bool | None
    """Whether it is right; None where it is not scored."""
    contact: str | None
    """Combined verdict; None without a judgement."""
    contact_right: bool | None
    """Whether it is right; None where it is not scored."""


def pick_frames(frames: Sequence[SimulatedFrame], limit: int = SHEET_FRAMES) -> list[int]:
    """Places of the frames worth showing, in order and without repeats.

    A stretch of one phase and one class gets a frame, then those in which most happens get further ones:
    equal states look the same, so what counts is the number of different states. Where there are more
    stretches than places, the first one of every class comes first, then the first of every phase, then the
    longest.

    Args:
        frames: The scored frames.
        limit: Largest number of frames to pick, at least 1.
    """
    classes = [frame.truth.frame_class for frame in frames]
    scenes = _most_telling(list(runs(list(zip(tell_phases(frames), classes, strict=True)))), limit)
    variety = [len({frame.truth.state for frame in frames[each.start : each.stop]}) for each in scenes]
    counts = [1] * len(scenes)
    for _ in range(limit - len(scenes)):
        wants = [each / count if count < each else 0.0 for each, count in zip(variety, counts, strict=True)]
        if not any(wants):
            break
        counts[wants.index(max(wants))] += 1
    return [
        each.start + (2 * k + 1) * each.length // (2 * count)
        for each, count in zip(scenes, counts, strict=True)
        for k in range(count)
    ]


def write_caption(frame: SimulatedFrame, phase: Phase, verdict: Verdict | None) -> Caption:
    """What to say about a frame; `verdict` is None where nobody judged it."""
    truth = frame.truth
    return Caption(
        index=truth.index,
        phase=str(phase),
        distance=gap_or_depth(truth.state.gap_mm),
        force=quantity(math.hypot(*truth.force_n), "N"),
        truth=str(truth.frame_class) if truth.frame_class else "not scored",
        proximity=str(verdict.proximity) if verdict else None,
        proximity_right=proximity_right(verdict, truth.frame_class) if verdict else None,
        contact=str(verdict.combined) if verdict else None,
        contact_right=contact_right(verdict, truth.frame_class) if verdict else None,
    )


def _most_telling(scenes: list[Scene], limit: int) -> list[Scene]:
    """At most `limit` of the stretches, in order."""
    if len(scenes) <= limit:
        return scenes
    places = range(len(scenes))
    first_of_class = {scenes[k].value[1]: k for k in reversed(places) if scenes[k].value[1]}
    first_of_phase = {scenes[k].value[0]: k for k in reversed(places)}
    longest = sorted(places, key=lambda k: -scenes[k].length)
    ranked = dict.fromkeys([*first_of_class.values(), *first_of_phase.values(), *longest])
    return [scenes[k] for k in sorted(list(ranked)[:limit])]
