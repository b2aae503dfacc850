"""Which episode goes into which split and file; an episode's place never depends on how many there are."""

import math
from dataclasses import dataclass

from magicsim.dataset.draw import sensor_of
from magicsim.dataset.recipe import Recipe
from magicsim.sampling.distribution import choose

GOLDEN = (math.sqrt(5) - 1) / 2
"""Multiples of it, without their whole part, are spread evenly, so that splits keep their shares at any size."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardPlan:
    """One file and what belongs into it."""

    file: str
    """Path below the dataset's folder."""
    split: str
    episodes: tuple[int, ...]


def split_of(recipe: Recipe, episode: int) -> str:
    """Name of the split that an episode belongs to."""
    unit = sensor_of(recipe, episode) if recipe.split_by == "sensor" else episode
    shares = recipe.splits.shares()
    return list(shares)[choose((0.5 + unit * GOLDEN) % 1.0, tuple(shares.values()))]


def plan_shards(recipe: Recipe) -> list[ShardPlan]:
    """All files of a dataset, by name."""
    members: dict[str, list[int]] = {}
    for episode in range(recipe.episodes):
        members.setdefault(split_of(recipe, episode), []).append(episode)
    size = recipe.episodes_per_shard
    return [
        ShardPlan(
            file=f"data/{split}-{number:05d}.parquet",
            split=split,
            episodes=tuple(members[split][number * size : (number + 1) * size]),
        )
        for split in sorted(members)
        for number in range(math.ceil(len(members[split]) / size))
    ]
