"""Flashlights of an episode: which happening each follows, when, how long and from where."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from magicsim_experiments.task.settings import GraspConfig

STREAM = 37
"""Keeps these random numbers apart from those of the story, which is the same with any flashlights."""
FRAMES = (5, 9)
"""Frames of a flashlight."""
SHIFT_MM, BESIDE_MM = 8.0, (20.0, 30.0)
"""Farthest shift of a flashlight before the approach; and while an item is there, beside which it then shines [mm]."""


class Since(StrEnum):
    """What has happened last before a flashlight."""

    BEGINNING = "beginning"
    """Nothing: no item is there."""
    OFFERED = "offered"
    """The hand offers the item, the fingers are open."""
    CLOSING = "closing"
    """The fingers close."""
    TRANSPORT = "transport"
    """The machine carries the item off."""
    PULL = "pull"
    """A hand pulls, until the item slips."""
    DELIVERED = "delivered"
    """The item is handed back at B, the fingers open."""


BEGINS = {
    Since.OFFERED: (0, 3), Since.CLOSING: (0, 8), Since.TRANSPORT: (0, 20), Since.PULL: (0, 3), Since.DELIVERED: (0, 6),
}  # fmt: skip
"""First and last frame after each happening in which a flashlight may begin; assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flashlight:
    """One flashlight."""

    since: Since
    begin: int
    """Frames from there to its first one."""
    frames: int
    """How long it shines."""
    x_mm: float
    """Shift along x [mm]."""

    def shines(self, passed: int) -> bool:
        """Whether it is on, so many frames after what it follows, below 0 while that has not happened."""
        return self.begin <= passed < self.begin + self.frames


def draw_anywhere(config: GraspConfig, episode: int, *, quiet: int, has_pull: bool) -> tuple[Flashlight, ...]:
    """Up to two flashlights, each after another happening of those that the story has, and within its first frames.

    Args:
        config: The task; `light_share` is the chance of each.
        episode: Its number.
        quiet: Frames before anything happens.
        has_pull: Whether a hand pulls: otherwise the item is delivered.
    """
    rng = np.random.default_rng(np.random.SeedSequence([config.seed, STREAM, episode]))
    count = int((rng.random(2) < config.light_share).sum())
    end = Since.PULL if has_pull else Since.DELIVERED
    choices = (Since.BEGINNING, Since.OFFERED, Since.CLOSING, Since.TRANSPORT, end)
    lights = []
    for place in rng.choice(len(choices), size=count, replace=False):
        since = choices[place]
        is_first = since is Since.BEGINNING
        begin = quiet if is_first else int(rng.integers(*BEGINS[since], endpoint=True))
        beside = float(rng.choice([-1, 1]) * rng.uniform(*BESIDE_MM))
        x_mm = float(rng.uniform(-SHIFT_MM, SHIFT_MM)) if is_first else beside
        frames = int(rng.integers(*FRAMES, endpoint=True))
        lights.append(Flashlight(since=since, begin=begin, frames=frames, x_mm=x_mm))
    return tuple(lights)
