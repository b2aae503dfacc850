"""Counts over all episodes, each with its exact interval, and the time in each stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from magicsim.detectors.grasp import GraspStage
from magicsim.detectors.verdict import Proximity
from magicsim.judge.measures import exact_share
from magicsim_experiments.task.episode import GraspRecord
from magicsim_experiments.task.settings import Item
from magicsim_experiments.task.story import Story

SEEN_WITHIN = 5
"""Frames within which the machine must see that an item was pulled away."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspOutcome:
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
    frames: int
    seconds_in: dict[str, float]
    noise_share: float | None
    """Share of the frames with a flashlight that proximity called Noise; None without any."""
    error: str
    """Why it ended early; empty otherwise."""


def judge_episode(recorded: GraspRecord, item: Item, story: Story, *, frames_per_second: float) -> GraspOutcome:
    """Holds the machine's way against what happened."""
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
    waits_at_a = rows[-1].stage == GraspStage.WAITING and rows[-1].carriage_mm == 0
    lit = [row for row in rows if row.light]
    return GraspOutcome(
        episode=rows[0].episode,
        item=story.item,
        mass_g=item.mass_g,
        is_completed=is_clean and (is_delivered or pulled is not None) and waits_at_a,
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """How many of how many, and the exact 95 % interval of the share (Clopper and Pearson)."""

    count: int
    of: int
    low: float | None
    """None of nothing."""
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Lit:
    """Frames with a flashlight in one stage of the machine."""

    frames: int
    noise: int
    episodes: int
    """Episodes that they are of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSummary:
    """What `magicsim task grasp` reports."""

    detector: str
    room: str
    episodes: int
    completed: Count
    delivered: Count
    """Items that were delivered, out of the episodes in which nobody pulled the item away."""
    slips_missed: Count
    """Slips that nobody saw, out of the items that were pulled away."""
    false_closes: Count
    """Episodes with one at least, as below."""
    false_slips: Count
    grasped_early: Count
    """Taken as grasped before the watched finger touched, of those that were taken as grasped."""
    offers_missed: Count
    drops: Count
    crushed: Count
    failed: Count
    """Ended early, as where no equilibrium was found."""
    reasons: dict[str, int]
    """Why they ended early, and how many of them."""
    seconds_in: dict[str, float]
    by_item: dict[str, Count]
    lit: dict[str, Lit]
    """Frames with a flashlight by the machine's stage, of stages that have any."""
    out: str


def counted(flags: Sequence[bool]) -> Count:
    """A count with its interval."""
    share = exact_share(sum(flags), len(flags))
    return Count(count=sum(flags), of=len(flags), low=share.low, high=share.high)


def reasons_of(errors: Sequence[str]) -> dict[str, int]:
    """How often each reason is there; an empty one is none."""
    return {error: errors.count(error) for error in sorted(set(errors)) if error}


def lit_by_stage(rows: Sequence[Mapping[str, Any]]) -> dict[str, Lit]:
    """Frames with a flashlight by the machine's stage, of rows as `GraspFrame` has them."""
    found = {}
    for stage in GraspStage:
        own = [row for row in rows if row["light"] and row["stage"] == stage]
        if own:
            noise = sum(row["proximity"] == Proximity.NOISE for row in own)
            found[stage.value] = Lit(frames=len(own), noise=noise, episodes=len({row["episode"] for row in own}))
    return found


def summarise(
    outcomes: Sequence[GraspOutcome], rows: Sequence[Mapping[str, Any]], *, detector: str, room: str, out: str
) -> TaskSummary:
    """Sums up a run with a detector in a room."""
    stages = outcomes[0].seconds_in if outcomes else {}
    items = sorted({each.item for each in outcomes})
    grasped = [each.grasped_at_gap_mm for each in outcomes if each.grasped_at_gap_mm is not None]
    return TaskSummary(
        detector=detector,
        room=room,
        episodes=len(outcomes),
        completed=counted([each.is_completed for each in outcomes]),
        delivered=counted([each.is_delivered for each in outcomes if not each.is_pulled]),
        slips_missed=counted([each.is_slip_missed for each in outcomes if each.is_pulled]),
        false_closes=counted([each.false_closes > 0 for each in outcomes]),
        false_slips=counted([each.false_slips > 0 for each in outcomes]),
        grasped_early=counted([gap > 0 for gap in grasped]),
        offers_missed=counted([each.is_offer_missed for each in outcomes]),
        drops=counted([each.is_dropped for each in outcomes]),
        crushed=counted([each.is_crushed for each in outcomes]),
        failed=counted([bool(each.error) for each in outcomes]),
        reasons=reasons_of([each.error for each in outcomes]),
        seconds_in={
            stage: round(sum(each.seconds_in[stage] for each in outcomes) / len(outcomes), 3) for stage in stages
        },
        by_item={item: counted([each.is_completed for each in outcomes if each.item == item]) for item in items},
        lit=lit_by_stage(rows),
        out=out,
    )
