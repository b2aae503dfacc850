"""Turns finished episodes into shards, in whatever order they end, and knows after an interruption what is left.

An episode's place, its split and file, never depends on how many episodes there are.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from magicsim.arrays import Index
from magicsim.dataset.manifest import FOLDER, STAGED, FailedEpisode, Manifest, ShardEntry
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import as_schema, read_episodes, read_rows, rows_as_bytes, write_rows
from magicsim.folder.ledger import WORK, Ledger
from magicsim.workers.attempt import Outcome
from magicsim.workers.run_folder import log_failures

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
        return self._count

    def __iter__(self) -> Iterator[ShardPlan]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> ShardPlan:
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


class Assembly:
    """The state of one run; everything that lasts is in the folder."""

    def __init__(self, ledger: Ledger, recipe: Recipe, manifest: Manifest, schema: pa.Schema) -> None:
        self.ledger, self.out, self.schema, self.manifest = ledger, ledger.out, schema, manifest
        self._layout = Layout(recipe)
        self.failed = {each.episode: each for each in manifest.failed if each.kind == "refused"}
        """Episodes without rows, by number."""
        self._shards = {entry.file: entry for entry in manifest.shards if ledger.is_intact(entry.file)}
        self._is_missing = np.ones(recipe.episodes, bool)
        self._closed: set[int] = set()
        waiting = self._waiting()
        known = waiting | set(self.failed) | {entry.episodes[0] for entry in self._shards.values() if entry.episodes}
        self._begun = {self._layout.number_of(each) for each in known if 0 <= each < recipe.episodes}
        for number in sorted(self._begun):
            self._take_up(number, waiting)

    def episodes_to_simulate(self) -> Index:
        """Numbers of those neither in a shard nor waiting for one, in order, shape (episodes left,)."""
        return np.flatnonzero(self._is_missing)

    def close_ready_shards(self) -> None:
        """Writes the shards whose episodes all wait already."""
        for number in sorted(self._begun - self._closed):
            self._close_if_whole(number)

    def take(self, outcome: Outcome[bytes]) -> None:
        """Takes the end of one episode, and closes its shard if it was the last one."""
        episode = outcome.key
        log_failures(self.out, "episode", episode, outcome.failures)
        if outcome.result is not None:
            self.ledger.place(_staged(episode), outcome.result)
            self.failed.pop(episode, None)
        else:
            last = outcome.failures[-1]
            self.failed[episode] = FailedEpisode(episode=episode, kind=last.kind.value, message=last.message)
        self._is_missing[episode] = False
        self._close_if_whole(self._layout.number_of(episode))

    def write_manifest(self) -> None:
        """Replaces the manifest by what is true now."""
        self.manifest = self.manifest.model_copy(
            update={
                "shards": tuple(self._shards[file] for file in sorted(self._shards)),
                "failed": tuple(self.failed[episode] for episode in sorted(self.failed)),
                "rows": sum(entry.rows for entry in self._shards.values()),
                "is_complete": len(self._closed) == len(self._layout),
            }
        )
        FOLDER.write_index(self.ledger, self.manifest)

    def _waiting(self) -> set[int]:
        """Numbers of the episodes that wait for their shard; what is damaged of them is dropped."""
        episodes = {int(path.stem.partition("-")[2]) for path in self.out.glob(STAGED)}
        damaged = {each for each in episodes if not self.ledger.is_intact(_staged(each))}
        for each in sorted(damaged):
            self.ledger.remove(_staged(each))
        return episodes - damaged

    def _take_up(self, number: int, waiting: set[int]) -> None:
        plan = self._layout[number]
        wanted = set(plan.episodes) - set(self.failed)
        entry = self._shards.get(plan.file)
        if entry is not None and set(entry.episodes) == wanted:
            self._closed.add(number)
        elif entry is not None:
            for episode, table in read_episodes(self.out / plan.file, wanted - waiting):
                self.ledger.place(_staged(episode), rows_as_bytes(as_schema(table, self.schema)))
                waiting.add(episode)
        missing = wanted - waiting if number not in self._closed else ()
        for episode in plan.episodes:
            self._is_missing[episode] = episode in missing

    def _close_if_whole(self, number: int) -> None:
        plan = self._layout[number]
        if self._is_missing[list(plan.episodes)].any():
            return
        episodes = tuple(episode for episode in plan.episodes if episode not in self.failed)
        if episodes:
            tables = (as_schema(read_rows(self.out / _staged(episode)), self.schema) for episode in episodes)
            with self.ledger.writing(plan.file) as partial:
                rows = write_rows(partial, tables, self.schema)
            entry = ShardEntry.of(self.ledger, plan.file, split=plan.split, episodes=episodes, rows=rows)
            self._shards[plan.file] = entry
        self._closed.add(number)
        self.write_manifest()
        for episode in plan.episodes:
            self.ledger.remove(_staged(episode))


def _staged(episode: int) -> str:
    """Name of a finished episode that waits for its shard."""
    return f"{WORK}/episode-{episode:08d}.parquet"
