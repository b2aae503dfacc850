"""What became of an episode, from its rows alone."""

from collections.abc import Sequence
from dataclasses import dataclass

from magicsim.detectors.grasp import GraspStage
from magicsim_experiments.task.episode import FrameRow, Recorded
from magicsim_experiments.task.item import Item
from magicsim_experiments.task.story import Story

SEEN_WITHIN = 5
"""Frames within which the machine must see that an item was pulled away."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One episode, judged."""

    episode: int
    item: str
    mass_g: float
    is_completed: bool
    """Delivered at B, or pulled away and seen to be; nothing wrong on the way, and the machine waits again at A."""
    is_delivered: bool
    is_pulled: bool
    """Whether a hand pulled the item out of the fingers."""
    slip_delay_frames: int | None
    """Frames from there to the stage Slipped; None where it was not seen, or nobody pulled."""
    is_slip_missed: bool
    """Pulled away and not seen within five frames."""
    false_slips: int
    """Slips seen while the item was held."""
    false_closes: int
    """Closings without an item."""
    grasped_at_gap_mm: float | None
    """Gap of the watched finger when the machine first took the item as grasped: above 0 it had not touched it yet
    [mm]; None where it never did."""
    is_offer_missed: bool
    """Whether the hand withdrew an item that was offered in vain."""
    is_dropped: bool
    """Whether the fingers lost the item without a pull."""
    is_crushed: bool
    """Whether a finger pressed harder than the item bears."""
    largest_n: float
    """Largest normal force [N]."""
    frames: int
    seconds_in: dict[str, float]
    """Time in each stage [s]."""
    noise_share: float | None
    """Share of the frames with a flashlight that proximity called Noise; None without any."""
    error: str
    """Why it ended early; empty otherwise."""


def judge_episode(recorded: Recorded, item: Item, story: Story, *, frames_per_second: float) -> Outcome:
    """Holds the machine's way against what happened.

    Args:
        recorded: The episode.
        item: What was gripped.
        story: What was drawn.
        frames_per_second: Rate of the frames [1/s].
    """
    rows = recorded.rows
    starts = [
        row for before, row in zip((None, *rows), rows, strict=False) if before is None or before.stage != row.stage
    ]
    pulled = next((row.frame for row in rows if row.event == "pulled"), None)
    slips = [row for row in starts if row.stage == GraspStage.SLIPPED]
    delay = next((row.frame - pulled for row in slips if row.frame >= pulled), None) if pulled is not None else None
    false_slips = sum(row.hold in {"held", "slipped", "placed"} for row in slips)
    false_closes = sum(row.stage == GraspStage.CLOSING and not row.has_item for row in starts)
    is_dropped = any(row.event == "dropped" for row in rows)
    largest = max(max(row.upper_n, row.lower_n) for row in rows)
    is_delivered = any(row.event == "delivered" for row in rows)
    is_missed = pulled is not None and (delay is None or delay >= SEEN_WITHIN)
    is_crushed = largest > item.crush_n
    is_clean = not (false_slips or false_closes or is_dropped or is_crushed or is_missed or recorded.error)
    lit = [row for row in rows if row.light]
    return Outcome(
        episode=rows[0].episode,
        item=story.item,
        mass_g=item.mass_g,
        is_completed=is_clean and (is_delivered or pulled is not None) and _waits_at_a(rows),
        is_delivered=is_delivered,
        is_pulled=pulled is not None,
        slip_delay_frames=delay,
        is_slip_missed=is_missed,
        false_slips=false_slips,
        false_closes=false_closes,
        grasped_at_gap_mm=next((row.gap_mm for row in starts if row.stage == GraspStage.GRASPED), None),
        is_offer_missed=any(row.event == "withdrawn" for row in rows),
        is_dropped=is_dropped,
        is_crushed=is_crushed,
        largest_n=largest,
        frames=len(rows),
        seconds_in={
            stage.value: round(sum(row.stage == stage for row in rows) / frames_per_second, 6) for stage in GraspStage
        },
        noise_share=sum(row.proximity == "Noise" for row in lit) / len(lit) if lit else None,
        error=recorded.error,
    )


def _waits_at_a(rows: Sequence[FrameRow]) -> bool:
    return rows[-1].stage == GraspStage.WAITING and rows[-1].carriage_mm == 0
