"""HDF5 and Zarr 3: each column of a split is one array with one entry a row."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.export.source import BYTES, MATRIX, VECTOR, Source, numbers
from magicsim.dataset.manifest import SENSORS
from magicsim.dataset.shard import Column

COMPRESSION = 4
"""Level of gzip in HDF5, 0..9."""
LARGE = 256
"""Numbers in a row from which on it is stored by itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArraySpec:
    """One array of a split."""

    name: str
    shape: tuple[int, ...]
    """Shape of one row."""
    dtype: str
    """NumPy's name, or `string`."""
    meaning: str

    def chunks(self, rows: int) -> tuple[int, ...]:
        """Chunk that is read and written together: one row of what is large, all rows of what is small."""
        return (1 if math.prod(self.shape) >= LARGE else rows, *self.shape)


def array_specs(source: Source) -> list[ArraySpec]:
    """Arrays that a dataset becomes. Whole numbers stay whole; numbers that may be missing are not a number there."""
    size, nodes = source.frame_size, _nodes(source)
    return [_spec(column, size, nodes) for column in source.columns]


def episode_values(source: Source, split: str) -> Iterator[tuple[str, slice, Any]]:
    """Content of a split, an episode at a time: an array's name, the rows, and their values."""
    done = 0
    specs = {spec.name: spec for spec in array_specs(source)}
    for table in (table for shard in source.shards(split) for table in source.episodes(shard)):
        rows = slice(done, done + table.num_rows)
        for column in source.columns:
            yield column.name, rows, _values(source, table, column, specs[column.name])
        done = rows.stop


def _nodes(source: Source) -> int:
    """Most lattice nodes of any sensor, 0 where no column has a field; shorter fields are filled up."""
    if not any(column.feature["_type"] == MATRIX for column in source.columns):
        return 0
    content = pa.BufferReader(source.content(SENSORS))
    lattices = pq.read_table(content, columns=["lattice_nodes_mm"])["lattice_nodes_mm"]
    return max(len(each) for each in lattices.to_pylist())


def _spec(column: Column, size: tuple[int, int], nodes: int) -> ArraySpec:
    kind, feature = column.feature["_type"], column.feature
    shape: tuple[int, ...]
    if kind == BYTES:
        shape, dtype = (size if column.name == "contact_mask" else (*size, 3)), "uint8"
    elif kind == MATRIX:
        shape, dtype = (feature["shape"][0] or nodes, feature["shape"][1]), feature["dtype"]
    elif kind == VECTOR:
        shape, dtype = (feature["length"],), "float64"
    else:
        shape, dtype = (), feature["dtype"]
    return ArraySpec(name=column.name, shape=shape, dtype=dtype, meaning=column.meaning)


def _values(source: Source, table: pa.Table, column: Column, spec: ArraySpec) -> npt.NDArray[Any] | list[str]:
    kind = column.feature["_type"]
    if kind == BYTES:
        return np.stack(source.pictures(table, column.name))
    if kind == MATRIX:
        filled = np.full((table.num_rows, *spec.shape), np.nan, spec.dtype)
        for place, matrix in enumerate(numbers(table, column)):
            filled[place, : len(matrix)] = matrix
        return filled
    if kind == VECTOR:
        return np.stack(numbers(table, column))
    values = table[column.name].to_pylist()
    if spec.dtype == "string":
        return ["" if value is None else value for value in values]
    return np.array([np.nan if value is None else value for value in values]).astype(spec.dtype)


def write_zarr(source: Source, folder: Path) -> None:
    """Writes a group for each split; texts are its attribute `texts`, because Zarr 3 has no standard type for them."""
    import zarr

    root = zarr.open_group(folder, mode="w", zarr_format=3)
    root.attrs["config_hash"] = source.manifest.config_hash
    root.attrs["config"] = source.config_text
    for split in source.splits:
        group: Any = root.create_group(split)
        rows = source.rows(split)
        texts: dict[str, list[str]] = {}
        for spec in array_specs(source):
            if spec.dtype == "string":
                texts[spec.name] = []
                continue
            shape, dtype = (rows, *spec.shape), np.dtype(spec.dtype)
            array = group.create_array(spec.name, shape=shape, dtype=dtype, chunks=spec.chunks(rows))
            array.attrs["description"] = spec.meaning
        for name, place, values in episode_values(source, split):
            if name in texts:
                texts[name].extend(values)
            else:
                group[name][place] = values
        group.attrs["texts"] = texts


def write_hdf5(source: Source, folder: Path) -> None:
    """Writes `<split>.h5`, one array a column; each carries its meaning as the attribute `description`."""
    import h5py

    for split in source.splits:
        with h5py.File(folder / f"{split}.h5", "w", track_order=True) as file:
            file.attrs["config_hash"] = source.manifest.config_hash
            file.attrs["config"] = source.config_text
            for spec in array_specs(source):
                rows = source.rows(split)
                dtype = h5py.string_dtype() if spec.dtype == "string" else np.dtype(spec.dtype)
                array = file.create_dataset(
                    spec.name, (rows, *spec.shape), dtype, chunks=spec.chunks(rows), compression=COMPRESSION
                )
                array.attrs["description"] = spec.meaning
            for name, place, values in episode_values(source, split):
                file[name][place] = values
