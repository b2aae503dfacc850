"""What happens in one episode beside the machine, drawn from its number alone: item, hand, pull, flashlights."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from magicsim_experiments.task.settings import GraspConfig

LIGHT_STREAM = 37
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
    x_mm: float

    def shines(self, passed: int) -> bool:
        """Whether it is on, so many frames after what it follows, below 0 while that has not happened."""
        return self.begin <= passed < self.begin + self.frames


def draw_anywhere(config: GraspConfig, episode: int, *, quiet: int, has_pull: bool) -> tuple[Flashlight, ...]:
    """Up to two flashlights, each after another happening of those that the story has, and within its first frames.

    A story is quiet for some frames at first; an item that no hand pulls away is delivered.
    """
    rng = np.random.default_rng(np.random.SeedSequence([config.seed, LIGHT_STREAM, episode]))
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


STREAM = 29
"""Keeps these random numbers apart from others of one seed."""
QUIET = (4, 9)
"""Frames before anything happens, the fewest and the most."""
ASIDE_MM, TWIST_DEG = 2.0, 5.0
"""How far from the middle a hand holds an item along y [mm], and turned about the closing axis [degrees]."""
HELD_FRAMES = 2
"""Frames of transport before a flashlight."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Story:
    """One episode as drawn."""

    item: str
    appears: int
    """Frame in which the hand begins to bring the item."""
    speed_mm_s: float
    y_mm: float
    """Where it holds the item along the fingers [mm]."""
    near_mm: float
    """Gap to the watched finger at which it offers it [mm]."""
    twist_deg: float
    """About it [degrees]."""
    lights: tuple[Flashlight, ...]
    pull: int | None
    """Frame of transport in which a hand begins to pull; None where nobody does."""
    pull_deg: float
    """Direction of the pull in the plane of the faces, from +x [degrees]."""


def draw_story(config: GraspConfig, episode: int) -> Story:
    """The story of one episode."""
    rng = np.random.default_rng(np.random.SeedSequence([config.seed, STREAM, episode]))
    quiet = int(rng.integers(*QUIET, endpoint=True))
    long = [int(rng.integers(*FRAMES, endpoint=True)) if rng.random() < config.light_share else 0 for _ in range(2)]
    transport = config.distance_mm / config.carriage_mm_s * config.frames_per_second
    pull = int(rng.uniform(0.3, 0.7) * transport) if rng.random() < config.pull_share else None
    item = config.items[int(rng.integers(len(config.items)))]
    speed = float(rng.uniform(*config.hand_mm_s))
    y_mm = float(rng.uniform(-ASIDE_MM, ASIDE_MM))
    near = float(rng.uniform(*config.near_mm))
    twist = float(rng.uniform(-TWIST_DEG, TWIST_DEG))
    shifts = (float(rng.uniform(-SHIFT_MM, SHIFT_MM)), float(rng.choice([-1, 1]) * rng.uniform(*BESIDE_MM)))
    usual = tuple(
        Flashlight(since=since, begin=begin, frames=frames, x_mm=x_mm)
        for since, begin, frames, x_mm in zip(
            (Since.BEGINNING, Since.TRANSPORT), (quiet, HELD_FRAMES), long, shifts, strict=True
        )
        if frames
    )
    is_anywhere = config.flashlight == "any"
    lights = draw_anywhere(config, episode, quiet=quiet, has_pull=pull is not None) if is_anywhere else usual
    return Story(
        item=item, appears=2 * quiet + sum(light.frames for light in lights if light.since is Since.BEGINNING),
        speed_mm_s=speed, y_mm=y_mm, near_mm=near, twist_deg=twist, lights=lights, pull=pull,
        pull_deg=float(rng.uniform(0, 360)),
    )  # fmt: skip
