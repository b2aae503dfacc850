"""Turns finished episodes into shards, in whatever order they end, and knows after an interruption what is left."""

from collections.abc import Iterator

import pyarrow as pa

from magicsim.dataset.folder import Staging
from magicsim.dataset.layout import ShardPlan, plan_shards
from magicsim.dataset.manifest import FailedEpisode, Manifest, ShardEntry, write_manifest
from magicsim.dataset.recipe import Recipe
from magicsim.dataset.shard import as_schema, read_episodes, rows_as_bytes, write_rows
from magicsim.folder.ledger import Ledger
from magicsim.workers.log import log_failures
from magicsim.workers.outcome import Outcome


class Assembly:
    """The state of one run; everything that lasts is in the folder."""

    def __init__(self, ledger: Ledger, recipe: Recipe, manifest: Manifest, schema: pa.Schema) -> None:
        """Takes up what an earlier run left."""
        self.ledger, self.out, self.schema = ledger, ledger.out, schema
        self.staging = Staging(ledger)
        self.manifest = manifest
        self._plans = plan_shards(recipe)
        self._place = {episode: plan for plan in self._plans for episode in plan.episodes}
        self._failed = {each.episode: each for each in manifest.failed if each.kind == "refused"}
        self._shards = {entry.file: entry for entry in manifest.shards if self._is_intact(entry)}
        self._missing: dict[str, set[int]] = {}
        waiting = self.staging.episodes()
        for plan in self._plans:
            self._take_up(plan, waiting)

    def episodes_to_simulate(self) -> list[int]:
        """What is neither in a shard nor waiting for one, in order."""
        return sorted(episode for missing in self._missing.values() for episode in missing)

    @property
    def rows(self) -> int:
        """Rows in finished shards."""
        return sum(entry.rows for entry in self._shards.values())

    @property
    def shards(self) -> int:
        """Finished shards."""
        return len(self._shards)

    @property
    def failed(self) -> int:
        """Episodes without rows."""
        return len(self._failed)

    def close_ready_shards(self) -> None:
        """Writes the shards whose episodes all wait already."""
        for plan in self._plans:
            if self._missing.get(plan.file) == set():
                self._close(plan)

    def take(self, outcome: Outcome[bytes]) -> None:
        """Takes the end of one episode, and closes its shard if it was the last one."""
        episode, plan = outcome.key, self._place[outcome.key]
        log_failures(self.out, "episode", episode, outcome.failures)
        if outcome.result is not None:
            self.staging.put(episode, outcome.result)
            self._failed.pop(episode, None)
        else:
            last = outcome.failures[-1]
            self._failed[episode] = FailedEpisode(episode=episode, kind=last.kind.value, message=last.message)
        self._missing[plan.file].discard(episode)
        if not self._missing[plan.file]:
            self._close(plan)

    def write_manifest(self) -> None:
        """Replaces the manifest by what is true now."""
        shards = tuple(self._shards[file] for file in sorted(self._shards))
        self.manifest = self.manifest.model_copy(
            update={
                "shards": shards,
                "failed": tuple(self._failed[episode] for episode in sorted(self._failed)),
                "rows": self.rows,
                "is_complete": not self._missing,
            }
        )
        write_manifest(self.ledger, self.manifest)

    def _take_up(self, plan: ShardPlan, waiting: set[int]) -> None:
        wanted = set(plan.episodes) - set(self._failed)
        entry = self._shards.get(plan.file)
        if entry is not None and set(entry.episodes) == wanted:
            return
        if entry is not None:
            for episode, table in read_episodes(self.out / plan.file, wanted - waiting):
                self.staging.put(episode, rows_as_bytes(as_schema(table, self.schema)))
                waiting.add(episode)
        self._missing[plan.file] = wanted - waiting

    def _close(self, plan: ShardPlan) -> None:
        """Writes a shard, then the manifest that knows it, and only then forgets its episodes."""
        episodes = tuple(episode for episode in plan.episodes if episode not in self._failed)
        if episodes:
            with self.ledger.writing(plan.file) as partial:
                rows = write_rows(partial, self._tables(episodes), self.schema)
            written = self.ledger.listed(plan.file)
            self._shards[plan.file] = ShardEntry(
                file=plan.file,
                split=plan.split,
                episodes=episodes,
                rows=rows,
                size=(self.out / plan.file).stat().st_size,
                sha256=written.sha256,
            )
        del self._missing[plan.file]
        self.write_manifest()
        self.staging.drop(episodes)

    def _tables(self, episodes: tuple[int, ...]) -> Iterator[pa.Table]:
        for episode in episodes:
            yield as_schema(self.staging.table(episode), self.schema)

    def _is_intact(self, entry: ShardEntry) -> bool:
        return self.ledger.is_intact(entry.file)
