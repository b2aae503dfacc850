"""The frames of a finished dataset by number: decoded images, masks and labels, for training loops.

Parquet is read by row groups, and a shuffled epoch would decode a hundred rows for each one. So the wanted columns are
copied once into an Arrow file, which is mapped into memory: any row is then there without reading another.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from magicsim.arrays import AnyArray, Index, Mask
from magicsim.dataset.export.source import BYTES, MATRIX, VECTOR, Source, matrix, open_dataset
from magicsim.dataset.manifest import check_size
from magicsim.dataset.shard import Column, decoded_png
from magicsim.errors import ConfigError, OutputError, unknown_choice
from magicsim.folder import result_file
from magicsim.folder.kept import FRAMES_VARIABLE, frames_folder, kept_copies

LABELS = (
    "image", "contact_mask", "force_n", "torque_nmm", "depth_mm", "gap_mm", "contact", "contact_area_mm2",
    "is_reference", "frame_class", "episode", "step", "sensor", "object_kind",
)  # fmt: skip
"""Columns that are there unless others are asked for."""
GROUPS = {"episode": "episode", "unit": "sensor", "object": "object_kind"}
"""What may not be in two splits, and the column that tells."""
COPIED = "compared 1 "
"""What the names of copies begin with before they are hashed; earlier ones may be of shards that had changed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameTable:
    """Some rows of a dataset; row numbers begin at 0."""

    columns: tuple[Column, ...]
    rows: Index
    """Numbers of its rows in the whole dataset, ascending."""
    split_of: npt.NDArray[np.str_]
    """Split that each row of the whole dataset is stored in."""
    path: Path

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, number: int) -> dict[str, Any]:
        """One row: images as uint8, (rows, columns, 3) RGB, masks as bool, vectors and matrices as arrays, else plain.

        Raises:
            IndexError: There is no such row.
            OutputError: A picture cannot be decoded.
        """
        row = int(self.rows[number])
        return {column.name: self._value(column, row) for column in self.columns}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (self[number] for number in range(len(self)))

    def column(self, name: str) -> AnyArray:
        """A column of plain values or vectors as one array, a row each; `ConfigError` for images and matrices."""
        column = next((each for each in self.columns if each.name == name), None)
        plain = [each.name for each in self.columns if each.feature["_type"] not in {BYTES, MATRIX}]
        if column is None or name not in plain:
            raise ConfigError(unknown_choice("plain column", name, plain))
        return self._plain(name)

    def where(self, chosen: Sequence[bool] | Mask) -> "FrameTable":
        """The rows for which an entry of `chosen`, one a row, is true."""
        return replace(self, rows=self.rows[np.asarray(chosen, bool)])

    def split(self, name: str) -> "FrameTable":
        """The rows of a split as it is stored; `ConfigError` where there is none of that name."""
        stored = self.split_of[self.rows]
        if name not in stored:
            raise ConfigError(unknown_choice("split", name, sorted(set(stored.tolist()))))
        return self.where(stored == name)

    def split_by(
        self, group: Literal["episode", "unit", "object"], shares: Mapping[str, float], *, seed: int = 0
    ) -> dict[str, "FrameTable"]:
        """Splits of which no two share an episode, a printed unit, or a kind of object.

        Args:
            group: What is never in two of them; without an object counts as a kind.
            shares: Weight of each split, by its name.
            seed: Of the order in which groups are dealt.

        Raises:
            ConfigError: An unknown group, a weight that is none, or fewer groups than splits.
        """
        if group not in GROUPS:
            raise ConfigError(unknown_choice("group", group, GROUPS))
        weights = np.array(list(shares.values()), float)
        if not len(weights) or not (weights > 0).all():
            raise ConfigError(f"shares = {dict(shares)} is not allowed: must be weights above 0")
        values = self._plain(GROUPS[group])
        names, member = np.unique(values, return_inverse=True)
        if len(names) < len(weights):
            msg = f"there are {len(names)} groups by {group} for {len(weights)} splits; name fewer, or another group"
            raise ConfigError(msg)
        place = np.empty(len(names), int)
        place[np.random.default_rng(seed).permutation(len(names))] = np.arange(len(names))
        ends = np.cumsum(weights) / weights.sum() * len(names)
        least = np.arange(1, len(weights) + 1)  # each split has a group, however small its share
        more = np.maximum.accumulate(np.maximum(np.rint(ends) - least, 0))
        ends = np.minimum(least + more, len(names) - least[::-1] + 1)
        part = np.searchsorted(ends, place, side="right")[member]
        return {name: self.where(part == number) for number, name in enumerate(shares)}

    def _value(self, column: Column, row: int) -> Any:  # noqa: ANN401 - as the column has them
        value, kind = self._table[column.name][row], column.feature["_type"]
        if kind == MATRIX:
            return matrix(value)
        if kind == BYTES:
            pixels = decoded_png(value["bytes"].as_py())
            if pixels is None:
                msg = f"'{self.path}', a copy of a dataset: {column.name} of row {row} is no PNG that can be decoded"
                raise OutputError(msg)
            return pixels > 0 if pixels.ndim == 2 else pixels  # noqa: PLR2004
        plain = value.as_py() if value.is_valid else column.empty
        return np.array(plain) if kind == VECTOR else plain

    def _plain(self, name: str) -> AnyArray:
        return np.array(self._table[name].take(pa.array(self.rows)).to_pylist())

    @property
    def _table(self) -> pa.Table:
        return _mapped(self.path)


@lru_cache(maxsize=16)
def _mapped(path: Path) -> pa.Table:
    """A copy that is mapped into memory, once in each process."""
    return pa.ipc.open_file(pa.memory_map(str(path))).read_all()


def open_frames(
    folder: Path | str, columns: Sequence[str] | None = None, *, keep: Path | str | None = None
) -> FrameTable:
    """The frames of a finished dataset.

    Args:
        folder: What `magicsim dataset --out` wrote.
        columns: Which of its columns; `LABELS`, as far as there are, by default.
        keep: Folder of the copy that is mapped; `MAGICSIM_FRAMES`, or `~/.cache/magicsim/frames`, by default. The
            copies that were asked for the longest ago go where all of them are larger than 50 GB.

    Raises:
        OutputError: There is no finished dataset, a shard is missing or not as it was written, or the copy cannot be
            written.
        ConfigError: There is no such column.
    """
    source = open_dataset(Path(folder))
    known = {each.name: each for each in source.columns}
    for name in columns or ():
        if name not in known:
            raise ConfigError(unknown_choice("column", name, known))
    names = list(dict.fromkeys([*(columns or LABELS), *GROUPS.values()]))
    wanted = tuple(known[name] for name in names if name in known)
    counts = [(split, source.rows(split)) for split in source.splits]
    return FrameTable(
        columns=tuple(each for each in wanted if columns is None or each.name in columns),
        rows=np.arange(sum(count for _, count in counts)),
        split_of=np.concatenate([np.full(count, split) for split, count in counts]),
        path=_copied(source, wanted, Path(keep) if keep else _default_folder()),
    )


def _default_folder() -> Path:
    folder = frames_folder()
    if folder is None:
        raise OutputError(f"there is no home folder for a copy of the frames: name one with keep or {FRAMES_VARIABLE}")
    return folder


def _copied(source: Source, columns: Sequence[Column], keep: Path) -> Path:
    """The Arrow file with some columns of a dataset, made where it is not there yet."""
    hashes = "".join(f"{entry.file}{entry.sha256}" for split in source.splits for entry in source.shards(split))
    names = ",".join(column.name for column in columns)
    path = keep / f"{hashlib.sha256(f'{COPIED}{hashes}{names}'.encode()).hexdigest()[:32]}.arrow"
    schema = pa.schema([pa.field(each.name, each.arrow) for each in columns])
    shards = [shard for split in source.splits for shard in source.shards(split)]
    if _is_whole(path, schema, sum(shard.rows for shard in shards)):
        for shard in shards:
            check_size(source.folder, shard.file, shard.listed)
        kept_copies(keep).touch(path)
        return path
    with result_file(path) as partial, pa.OSFile(str(partial), "wb") as sink, pa.ipc.new_file(sink, schema) as writer:
        for table in (table for shard in shards for table in source.episodes(shard)):
            writer.write_table(table.select([column.name for column in columns]).cast(schema))
    kept_copies(keep).shrink()
    _mapped.cache_clear()  # there may have been a damaged one of this name
    return path


def _is_whole(path: Path, schema: pa.Schema, rows: int) -> bool:
    """Whether a copy is there, with these columns and so many rows."""
    if not path.is_file():
        return False
    try:
        with pa.memory_map(str(path)) as mapped:
            table = pa.ipc.open_file(mapped).read_all()
            return bool(table.schema == schema and table.num_rows == rows)
    except (pa.ArrowException, OSError):
        return False
