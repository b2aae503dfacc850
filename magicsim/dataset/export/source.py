"""A finished dataset as exporters read it: one episode at a time, in order."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from magicsim.dataset.columns import columns_of, recorded_columns
from magicsim.dataset.manifest import (
    CONFIG,
    MANIFEST,
    Manifest,
    Recorded,
    ShardEntry,
    known_manifest,
    listed_content,
    read_recorded,
)
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.dataset.shard import Column, decoded_png, read_shard, schema_of_columns
from magicsim.errors import OutputError

BYTES, MATRIX, VECTOR = "Image", "Array2D", "Sequence"


@dataclass(frozen=True)
class Source:
    """One dataset on disk."""

    folder: Path
    manifest: Manifest

    @cached_property
    def recorded(self) -> Recorded | None:
        """Facts about frames of a real sensor; None of simulated ones."""
        return read_recorded(self.folder)

    @cached_property
    def recipe(self) -> Recipe:
        """What it was drawn from; `OutputError` where frames were recorded, or the recipe's file has changed."""
        if self.recorded is not None:
            raise OutputError(f"'{self.folder}' holds recorded frames, which no recipe draws")
        self.content(CONFIG)
        return load_recipe(self.folder / CONFIG)

    @cached_property
    def columns(self) -> list[Column]:
        """Columns of the rows."""
        if self.recorded is None:
            return columns_of(self.recipe)
        return [each for each in recorded_columns() if each.name in self.recorded.table]

    def content(self, name: str) -> bytes:
        """Content of a file beside the shards; an `OutputError` names it where it is not as the manifest lists."""
        listed = self.manifest.listed().get(name)
        if listed is None:
            raise OutputError(f"'{self.folder / name}' is not listed in {MANIFEST}")
        return listed_content(self.folder, name, listed)

    @property
    def config_text(self) -> str:
        """The recipe, or the description of recorded frames, as TOML."""
        name = CONFIG if self.recorded is None else self.recorded.description
        return self.content(name).decode()

    @property
    def frame_size(self) -> tuple[int, int]:
        """Rows and columns of its frames [px]."""
        if self.recorded is not None:
            return self.recorded.rows, self.recorded.columns
        window = self.recipe.rig.camera.window
        return window.rows, window.columns

    @property
    def frames_per_second(self) -> float | None:
        """Frame rate [1/s]; None where frames were recorded and nobody said when."""
        return self.recipe.frames_per_second if self.recorded is None else self.recorded.frames_per_second

    @property
    def splits(self) -> list[str]:
        """Names of its splits."""
        return sorted({entry.split for entry in self.manifest.shards})

    def shards(self, split: str) -> list[ShardEntry]:
        """Files of a split."""
        return [entry for entry in self.manifest.shards if entry.split == split]

    def episodes(self, shard: ShardEntry) -> Iterator[pa.Table]:
        """Rows of each episode of a shard; an `OutputError` names it where it is not as the manifest lists."""
        whole = read_shard(self.folder, shard, schema_of_columns(self.columns))
        numbers = whole["episode"].to_pylist()
        for episode in shard.episodes:
            if episode not in numbers:
                msg = f"'{self.folder / shard.file}' holds no row of episode {episode}, which {MANIFEST} lists"
                raise OutputError(msg)
            yield whole.slice(numbers.index(episode), numbers.count(episode))

    def pictures(self, table: pa.Table, name: str) -> list[npt.NDArray[np.uint8]]:
        """Pixels of an image column of an episode's rows: (rows, columns, 3) RGB for frames, (rows, columns) for masks.

        An `OutputError` names file, episode and row of one that cannot be decoded.
        """
        pictures = []
        for row, value in enumerate(table[name].to_pylist()):
            pixels = decoded_png(value["bytes"] if value is not None else None)
            if pixels is None:
                episode = table["episode"][0].as_py()
                file = next((each.file for each in self.manifest.shards if episode in each.episodes), "")
                msg = f"'{self.folder / file}': {name} of row {row} of episode {episode} is no PNG that can be decoded"
                raise OutputError(msg)
            pictures.append(pixels)
        return pictures

    def rows(self, split: str) -> int:
        """Rows of a split."""
        return sum(entry.rows for entry in self.shards(split))


def open_dataset(folder: Path) -> Source:
    """A finished dataset to export; `OutputError` where the folder holds none."""
    manifest = known_manifest(folder)
    if not manifest.is_complete or not manifest.shards:
        raise OutputError(f"'{folder}' holds an unfinished dataset; the command that made it finishes it with --resume")
    return Source(folder=folder, manifest=manifest)


def numbers(table: pa.Table, column: Column) -> list[npt.NDArray[Any]]:
    """Matrices of an `Array2D` column, one a row; vectors of a `Sequence`, not a number where there is none."""
    values = table[column.name].combine_chunks()
    if column.feature["_type"] == VECTOR:
        missing = [float("nan")] * column.feature["length"]
        return [np.array(value if value is not None else missing) for value in values.to_pylist()]
    return [matrix(values[place]) for place in range(len(values))]


def matrix(value: pa.ListScalar) -> npt.NDArray[Any]:
    """One entry of an `Array2D` column."""
    inner = value.values
    return np.asarray(inner.flatten().to_numpy(zero_copy_only=False)).reshape(len(inner), -1)
