"""Counts over all episodes, each with its exact interval, and the time in each stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from magicsim.detectors.grasp import GraspStage
from magicsim.detectors.verdict import Proximity
from magicsim.judge.measures import exact_share
from magicsim_experiments.task.outcome import Outcome


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
    """Those that proximity called Noise."""
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
    """Mean time in each stage [s]."""
    by_item: dict[str, Count]
    """Completed episodes of each item."""
    lit: dict[str, Lit]
    """Frames with a flashlight by the machine's stage, of stages that have any."""
    out: str

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        from dataclasses import asdict

        return asdict(self)


def counted(flags: Sequence[bool]) -> Count:
    """A count with its interval."""
    share = exact_share(sum(flags), len(flags))
    return Count(count=sum(flags), of=len(flags), low=share.low, high=share.high)


def reasons_of(errors: Sequence[str]) -> dict[str, int]:
    """How often each reason is there; an empty one is none."""
    return {error: errors.count(error) for error in sorted(set(errors)) if error}


def lit_by_stage(rows: Sequence[Mapping[str, Any]]) -> dict[str, Lit]:
    """Frames with a flashlight by the machine's stage.

    Args:
        rows: Of all episodes, as `magicsim_experiments.task.episode.FrameRow` has them.
    """
    found = {}
    for stage in GraspStage:
        own = [row for row in rows if row["light"] and row["stage"] == stage]
        if own:
            noise = sum(row["proximity"] == Proximity.NOISE for row in own)
            found[stage.value] = Lit(frames=len(own), noise=noise, episodes=len({row["episode"] for row in own}))
    return found


def summarise(
    outcomes: Sequence[Outcome], rows: Sequence[Mapping[str, Any]], *, detector: str, room: str, out: str
) -> TaskSummary:
    """Sums up a run.

    Args:
        outcomes: All episodes.
        rows: Their frames.
        detector: Profile that read the frames.
        room: Where the gripper stood.
        out: Folder of the run.
    """
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
