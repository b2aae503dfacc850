"""Which episode goes into which split and file; an episode's place never depends on how many there are."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from magicsim.dataset.recipes.recipe import Recipe

GOLDEN = (math.sqrt(5) - 1) / 2
"""Multiples of it, without their whole part, are spread evenly, so that splits keep their shares at any size."""
AT_ONCE = 1 << 18
"""Episodes that are sorted into splits at once, which bounds the memory that takes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardPlan:
    """One file and what belongs into it."""

    file: str
    """Path below the dataset's folder."""
    split: str
    episodes: tuple[int, ...]


def split_of(recipe: Recipe, episode: int) -> str:
    """Name of the split that an episode belongs to."""
    return list(recipe.splits.shares())[int(_splits(recipe, np.array([episode]))[0])]


class Layout:
    """All files of a dataset, by name; what belongs into one is looked up when it is asked for."""

    def __init__(self, recipe: Recipe) -> None:
        """Sorts the episodes into splits: a few bytes for each."""
        self._size, self._names = recipe.episodes_per_shard, list(recipe.splits.shares())
        parts = [
            _splits(recipe, np.arange(begin, min(begin + AT_ONCE, recipe.episodes)))
            for begin in range(0, recipe.episodes, AT_ONCE)
        ]
        self._split_of = np.concatenate(parts)
        self._members = [
            np.flatnonzero(self._split_of == number).astype(np.int32) for number in range(len(self._names))
        ]
        order = sorted(range(len(self._names)), key=self._names.__getitem__)
        counts = [math.ceil(len(self._members[number]) / self._size) for number in order]
        self._begins = dict(zip(order, accumulate(counts, initial=0), strict=False))
        self._count = sum(counts)

    @property
    def splits(self) -> list[str]:
        """Names of the splits that hold episodes, in the order of the recipe."""
        return [name for name, members in zip(self._names, self._members, strict=True) if len(members)]

    def __len__(self) -> int:
        """Number of files."""
        return self._count

    def __iter__(self) -> Iterator[ShardPlan]:
        """All files in order."""
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> ShardPlan:
        """One file by its number."""
        split = [each for each in self._begins if self._begins[each] <= index][-1]  # of equal ones all but it are empty
        number = index - self._begins[split]
        return ShardPlan(
            file=f"data/{self._names[split]}-{number:05d}.parquet",
            split=self._names[split],
            episodes=tuple(self._members[split][number * self._size : (number + 1) * self._size].tolist()),
        )

    def number_of(self, episode: int) -> int:
        """Number of the file that an episode belongs into."""
        split = int(self._split_of[episode])
        return self._begins[split] + int(np.searchsorted(self._members[split], episode)) // self._size


def _splits(recipe: Recipe, episodes: npt.NDArray[np.int64]) -> npt.NDArray[np.int8]:
    """Numbers of the splits that episodes belong to."""
    units = episodes // recipe.episodes_per_sensor if recipe.split_by == "sensor" else episodes
    weights = np.array(list(recipe.splits.shares().values()))
    ends = np.cumsum(weights) / np.sum(weights)
    splits = np.searchsorted(ends, (0.5 + units * GOLDEN) % 1.0, side="right")
    return np.minimum(splits, len(weights) - 1).astype(np.int8)
