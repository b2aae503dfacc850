"""What happens in one episode beside the machine, drawn from its number alone: item, hand, pull, flashlights."""

from dataclasses import dataclass

import numpy as np

from magicsim.task.settings import GraspConfig

STREAM = 29
"""Keeps these random numbers apart from others of one seed."""
QUIET = (4, 9)
"""Frames before anything happens, the fewest and the most."""
LIGHT = (5, 9)
"""Frames of a flashlight."""
ASIDE_MM, TWIST_DEG = 2.0, 5.0
"""How far from the middle a hand holds an item along y [mm], and turned about the closing axis [degrees]."""
LIGHT_MM, BESIDE_MM = 8.0, (20.0, 30.0)
"""Farthest shift of a flashlight before the approach; and while an item is held, beside which it then shines [mm]."""


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
    light_before: tuple[int, int] | None
    """First frame of a flashlight before the approach and the one after its last."""
    light_held: tuple[int, int] | None
    """Another one, counted from the beginning of transport."""
    light_x_mm: tuple[float, float]
    """Shifts of the two [mm]."""
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
    lights = [int(rng.integers(*LIGHT, endpoint=True)) if rng.random() < config.light_share else 0 for _ in range(2)]
    before, held = lights
    transport = config.distance_mm / config.carriage_mm_s * config.frames_per_second
    pull = int(rng.uniform(0.3, 0.7) * transport) if rng.random() < config.pull_share else None
    return Story(
        item=config.items[int(rng.integers(len(config.items)))],
        appears=2 * quiet + before,
        speed_mm_s=float(rng.uniform(*config.hand_mm_s)),
        y_mm=float(rng.uniform(-ASIDE_MM, ASIDE_MM)),
        near_mm=float(rng.uniform(*config.near_mm)),
        twist_deg=float(rng.uniform(-TWIST_DEG, TWIST_DEG)),
        light_before=(quiet, quiet + before) if before else None,
        light_held=(2, 2 + held) if held else None,
        light_x_mm=(float(rng.uniform(-LIGHT_MM, LIGHT_MM)), float(rng.choice([-1, 1]) * rng.uniform(*BESIDE_MM))),
        pull=pull,
        pull_deg=float(rng.uniform(0, 360)),
    )
