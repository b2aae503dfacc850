"""What became of the episodes: how well the angle was read, and how upright the items ended."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from magicsim_experiments.learn.baselines import mean_score
from magicsim_experiments.task.alignment.episode import AlignmentFrame, AlignmentRecord
from magicsim_experiments.task.alignment.grip import Grip
from magicsim_experiments.task.summary import Count, counted, reasons_of

READERS = {"both fingers": "read_deg", "upper finger": "upper_deg", "lower finger": "lower_deg"}
"""Whose reading an error is of, and the rows' column."""
CONSTANT = "constant"
"""Who always answers 0, the middle of all angles: the wrist would not turn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignmentOutcome:
    """One episode, judged."""

    episode: int
    item: str
    askew_deg: float
    """Angle at which a hand put the item between the fingers [degrees]."""
    start_deg: float | None
    """Size of the first frame's error [degrees]; None without a frame."""
    end_deg: float | None
    """Size of the last frame's error [degrees]; None where the item was lost or an equilibrium was not found."""
    seconds: float | None
    """Time from which on the error stays below the limit [s]; None where it does not."""
    turned_in_grip_deg: float | None
    """How far the item turned in the grip, first to last frame [degrees]."""
    is_upright: bool
    """Whether it ended below the limit."""
    is_dropped: bool
    frames: int
    error: str
    """Why it ended early; empty otherwise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mean:
    """A mean with its 95 % interval over episodes, drawn again with replacement."""

    value: float | None
    """None of nothing."""
    low: float | None
    high: float | None
    """None of fewer than two episodes, which say nothing of others."""
    episodes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Episodes of some items."""

    episodes: int
    upright: Count
    start_deg: Mean
    end_deg: Mean
    seconds: float | None
    """Median time until upright, of those that became so [s]."""
    read_error_deg: dict[str, Mean]
    """Mean absolute error of the angle in the grip over all frames, by who read it [degrees]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignmentSummary:
    """What `magicsim task alignment` reports."""

    out: str
    episodes: int
    within_deg: float
    """Error below which an item counts as upright [degrees]."""
    seen: Group
    """Items like those that the model has learned from."""
    unseen: Group
    """Others."""
    by_item: dict[str, Mean]
    """Error at last of each item [degrees]."""
    dropped: Count
    failed: Count
    """Ended early, as where no equilibrium was found."""
    reasons: dict[str, int]
    """Why they ended early, and how many of them."""


def judge_episode(recorded: AlignmentRecord, grip: Grip, *, episode: int, within_deg: float) -> AlignmentOutcome:
    """Holds an episode against the error below which an item counts as upright [degrees]."""
    rows = recorded.rows
    errors = [abs(row.error_deg) for row in rows]
    is_whole = bool(rows) and not recorded.is_dropped and not recorded.error
    late = next((k + 1 for k in range(len(rows) - 1, -1, -1) if errors[k] > within_deg), 0)
    is_upright = is_whole and late < len(rows)
    return AlignmentOutcome(
        episode=episode, item=grip.item, askew_deg=grip.askew_deg, start_deg=errors[0] if rows else None,
        end_deg=errors[-1] if is_whole else None, seconds=rows[late].time_s if is_upright else None,
        turned_in_grip_deg=rows[-1].held_deg - rows[0].held_deg if rows else None, is_upright=is_upright,
        is_dropped=recorded.is_dropped, frames=len(rows), error=recorded.error,
    )  # fmt: skip


def summarise(
    outcomes: Sequence[AlignmentOutcome], rows: Sequence[AlignmentFrame], *, unseen: Sequence[str], within_deg: float,
    out: str,
) -> AlignmentSummary:  # fmt: skip
    """Sums up a run; `unseen` names the items that are counted apart."""
    items = sorted({each.item for each in outcomes})
    return AlignmentSummary(
        out=out, episodes=len(outcomes), within_deg=within_deg,
        seen=_group([each for each in outcomes if each.item not in unseen], rows),
        unseen=_group([each for each in outcomes if each.item in unseen], rows),
        by_item={item: _ends([each for each in outcomes if each.item == item]) for item in items},
        dropped=counted([each.is_dropped for each in outcomes]),
        failed=counted([bool(each.error) for each in outcomes]), reasons=reasons_of([each.error for each in outcomes]),
    )  # fmt: skip


def _group(outcomes: Sequence[AlignmentOutcome], rows: Sequence[AlignmentFrame]) -> Group:
    numbers = {each.episode for each in outcomes}
    own = [row for row in rows if row.episode in numbers]
    episodes = [row.episode for row in own]
    truth = np.array([row.held_deg for row in own])
    errors = {
        name: mean(np.abs(np.array([getattr(row, column) for row in own]) - truth), episodes)
        for name, column in READERS.items()
    }
    times = [each.seconds for each in outcomes if each.seconds is not None]
    starts = [each.start_deg for each in outcomes if each.start_deg is not None]
    return Group(
        episodes=len(outcomes), upright=counted([each.is_upright for each in outcomes]),
        start_deg=mean(starts, range(len(starts))), end_deg=_ends(outcomes),
        seconds=float(np.median(times)) if times else None,
        read_error_deg=errors | {CONSTANT: mean(np.abs(truth), episodes)},
    )  # fmt: skip


def _ends(outcomes: Sequence[AlignmentOutcome]) -> Mean:
    ends = [each.end_deg for each in outcomes if each.end_deg is not None]
    return mean(ends, range(len(ends)))


def mean(values: Sequence[float] | np.ndarray, episodes: Sequence[int]) -> Mean:
    """A mean over frames or episodes, whole episodes drawn again for its interval."""
    if not len(values):
        return Mean(value=None, low=None, high=None, episodes=0)
    score = mean_score(np.asarray(values, float), np.asarray(episodes, np.int64))
    low, high = (score.low, score.high) if score.presses > 1 else (None, None)
    return Mean(value=score.value, low=low, high=high, episodes=score.presses)
