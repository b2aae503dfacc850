"""What happens in one episode beside the machine, drawn from its number alone: item, hand, pull, flashlights."""

from dataclasses import dataclass

import numpy as np

from magicsim_experiments.task.flashlight import BESIDE_MM, FRAMES, SHIFT_MM, Flashlight, Since, draw_anywhere
from magicsim_experiments.task.settings import GraspConfig

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
    """Speed of the hand [mm/s]."""
    y_mm: float
    """Where it holds the item along the fingers [mm]."""
    near_mm: float
    """Gap to the watched finger at which it offers it [mm]."""
    twist_deg: float
    """About it [degrees]."""
    lights: tuple[Flashlight, ...]
    """Flashlights of the episode."""
    pull: int | None
    """Frame of transport in which a hand begins to pull; None where nobody does."""
    pull_deg: float
    """Direction of the pull in the plane of the faces, from +x [degrees]."""


def draw_story(config: GraspConfig, episode: int) -> Story:
    """The story of one episode.

    Args:
        config: The task.
        episode: Its number.
    """
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
        item=item,
        appears=2 * quiet + sum(light.frames for light in lights if light.since is Since.BEGINNING),
        speed_mm_s=speed,
        y_mm=y_mm,
        near_mm=near,
        twist_deg=twist,
        lights=lights,
        pull=pull,
        pull_deg=float(rng.uniform(0, 360)),
    )
