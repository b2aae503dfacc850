"""Writes a dataset in another library's layout: HDF5, Zarr 3 and WebDataset here, LeRobot and MCAP beside.

In HDF5 and Zarr each column of a split is one array with one entry a row.
"""

import importlib
import io
import json
import math
import os
import tarfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from magicsim.config.documents import without_nan
from magicsim.dataset.export.source import BYTES, MATRIX, VECTOR, Source, numbers, open_dataset
from magicsim.dataset.manifest import SENSORS
from magicsim.dataset.shard import Column, plain_column
from magicsim.errors import ConfigError, OutputError
from magicsim.folder import result_folder

COMPRESSION = 4
"""Level of gzip in HDF5, 0..9."""
LARGE = 256
"""Numbers in a row from which on it is stored by itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArraySpec:
    """The array of a split that a column becomes."""

    column: Column
    shape: tuple[int, ...]
    """Shape of one row."""
    dtype: str
    """NumPy's name, or `string`."""

    @property
    def name(self) -> str:
        """Name of the column."""
        return self.column.name

    def chunks(self, rows: int) -> tuple[int, ...]:
        """Chunk that is read and written together: one row of what is large, all rows of what is small."""
        return (1 if math.prod(self.shape) >= LARGE else rows, *self.shape)


def array_specs(source: Source) -> list[ArraySpec]:
    """Arrays that a dataset becomes. Whole numbers stay whole; numbers that may be missing are not a number there."""
    nodes = _nodes(source)
    return [_spec(column, source.frame_size, nodes) for column in source.columns]


def episode_values(source: Source, split: str, specs: list[ArraySpec]) -> Iterator[tuple[str, slice, Any]]:
    """Content of a split, an episode at a time: an array's name, the rows, and their values."""
    done = 0
    for table in (table for shard in source.shards(split) for table in source.episodes(shard)):
        rows = slice(done, done + table.num_rows)
        for spec in specs:
            yield spec.name, rows, _values(source, table, spec)
        done = rows.stop


def _nodes(source: Source) -> int:
    """Most lattice nodes of any sensor, 0 where no column has a field; shorter fields are filled up."""
    if not any(column.feature["_type"] == MATRIX for column in source.columns):
        return 0
    content = pa.BufferReader(source.content(SENSORS))
    lattices = plain_column(pq.read_table(content, columns=["lattice_nodes_mm"]), "lattice_nodes_mm")
    return int(pc.max(pc.list_value_length(lattices)).as_py())


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
    return ArraySpec(column=column, shape=shape, dtype=dtype)


def _values(source: Source, table: pa.Table, spec: ArraySpec) -> npt.NDArray[Any] | list[str]:
    kind = spec.column.feature["_type"]
    if kind == BYTES:
        return np.stack(source.pictures(table, spec.name))
    if kind == MATRIX:
        filled = np.full((table.num_rows, *spec.shape), np.nan, spec.dtype)
        for place, matrix in enumerate(numbers(table, spec.column)):
            filled[place, : len(matrix)] = matrix
        return filled
    if kind == VECTOR:
        return np.stack(numbers(table, spec.column))
    values = table[spec.name].to_pylist()
    if spec.dtype == "string":
        return ["" if value is None else value for value in values]
    return np.array([np.nan if value is None else value for value in values]).astype(spec.dtype)


def write_zarr(source: Source, folder: Path) -> None:
    """Writes a group for each split; texts are its attribute `texts`, because Zarr 3 has no standard type for them."""
    import zarr

    root = zarr.open_group(folder, mode="w", zarr_format=3)
    root.attrs["config_hash"] = source.manifest.config_hash
    root.attrs["config"] = source.config_text
    specs = array_specs(source)
    for split in source.splits:
        group: Any = root.create_group(split)
        rows = source.rows(split)
        texts: dict[str, list[str]] = {spec.name: [] for spec in specs if spec.dtype == "string"}
        for spec in specs:
            if spec.name not in texts:
                shape, dtype = (rows, *spec.shape), np.dtype(spec.dtype)
                array = group.create_array(spec.name, shape=shape, dtype=dtype, chunks=spec.chunks(rows))
                array.attrs["description"] = spec.column.meaning
        for name, place, values in episode_values(source, split, specs):
            if name in texts:
                texts[name].extend(values)
            else:
                group[name][place] = values
        group.attrs["texts"] = texts


def write_hdf5(source: Source, folder: Path) -> None:
    """Writes `<split>.h5`, one array a column; each carries its meaning as the attribute `description`."""
    import h5py

    specs = array_specs(source)
    for split in source.splits:
        rows = source.rows(split)
        with h5py.File(folder / f"{split}.h5", "w", track_order=True) as file:
            file.attrs["config_hash"] = source.manifest.config_hash
            file.attrs["config"] = source.config_text
            for spec in specs:
                dtype = h5py.string_dtype() if spec.dtype == "string" else np.dtype(spec.dtype)
                array = file.create_dataset(
                    spec.name, (rows, *spec.shape), dtype, chunks=spec.chunks(rows), compression=COMPRESSION
                )
                array.attrs["description"] = spec.column.meaning
            for name, place, values in episode_values(source, split, specs):
                file[name][place] = values


Format = Literal["lerobot", "webdataset", "hdf5", "mcap", "zarr"]
OF_SIMULATED = frozenset({"lerobot", "mcap"})
"""Layouts that hold the camera's calibration or every frame's contact, which recordings lack."""
PACKAGES = {"hdf5": "h5py", "mcap": "foxglove", "zarr": "zarr"}
"""What a layout needs that is not installed with the program."""
ENDINGS = {"image": "png", "contact_mask": "mask.png"}
"""Names of pictures in a WebDataset."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Exported:
    """What `magicsim dataset export` reports."""

    format: str
    samples: int
    files: int
    seconds: float
    out: str


def export_dataset(folder: Path, out: Path, layout: Format) -> Exported:
    """Writes a finished dataset in another layout.

    Raises:
        OutputError: There is no finished dataset or a file of it is not as it was written, or the target exists, is
            inside of the dataset or cannot be written.
        ConfigError: The layout's library is not installed, or needs more than is known of recorded frames.
    """
    start = time.perf_counter()
    source = open_dataset(folder)
    if source.recorded is not None and layout in OF_SIMULATED:
        others = ", ".join(each for each in get_args(Format) if each not in OF_SIMULATED)
        msg = f"format = {layout} is not allowed for recorded frames, whose calibration is not known: must be {others}"
        raise ConfigError(msg)
    if Path(os.path.realpath(out)).is_relative_to(os.path.realpath(folder)):
        raise OutputError(f"output folder '{out}' is inside of the dataset '{folder}'; name a folder elsewhere")
    if out.exists():
        raise OutputError(f"output folder '{out}' exists; name a new folder")
    writer = _writer(layout)
    with result_folder(out, is_listed=False) as partial:
        writer(source, partial)
    return Exported(
        format=layout,
        samples=source.manifest.rows,
        files=sum(path.is_file() for path in out.rglob("*")),
        seconds=round(time.perf_counter() - start, 3),
        out=str(out),
    )


def _writer(layout: Format) -> Callable[[Source, Path], None]:
    try:
        if layout in PACKAGES:
            importlib.import_module(PACKAGES[layout])
    except ImportError as error:
        msg = f"format '{layout}' needs the package {error.name}: pip install 'magicsim[{layout}]'"
        raise ConfigError(msg) from None
    if layout == "webdataset":
        return write_webdataset
    if layout == "lerobot":
        from magicsim.dataset.export.lerobot import write_lerobot

        return write_lerobot
    if layout == "mcap":
        from magicsim.dataset.export.mcap import write_mcap

        return write_mcap
    return write_hdf5 if layout == "hdf5" else write_zarr


def write_webdataset(source: Source, folder: Path) -> None:
    """Writes `<split>-NNNNNN.tar`, one for each shard; plain columns are in `json`, matrices in `<column>.npy`."""
    for split in source.splits:
        for number, shard in enumerate(source.shards(split)):
            with tarfile.open(folder / f"{split}-{number:06d}.tar", "w") as archive:
                for table in source.episodes(shard):
                    _write_episode(archive, source, table)


def _write_episode(archive: tarfile.TarFile, source: Source, table: pa.Table) -> None:
    large = [column for column in source.columns if column.feature["_type"] in {BYTES, MATRIX}]
    plain = table.drop_columns([column.name for column in large]).to_pylist()
    matrices = {column.name: numbers(table, column) for column in large if column.feature["_type"] == MATRIX}
    images = {name: table[name].to_pylist() for name in ENDINGS if name in table.column_names}
    for place, row in enumerate(plain):
        key = f"{row['episode']:08d}_{row['step']:04d}"
        for name, values in images.items():
            _add(archive, f"{key}.{ENDINGS[name]}", values[place]["bytes"])
        for name, arrays in matrices.items():
            np.save(stored := io.BytesIO(), arrays[place])
            _add(archive, f"{key}.{name}.npy", stored.getvalue())
        _add(archive, f"{key}.json", json.dumps(without_nan(row), allow_nan=False).encode())


def _add(archive: tarfile.TarFile, name: str, content: bytes) -> None:
    member = tarfile.TarInfo(name)
    member.size = len(content)
    archive.addfile(member, io.BytesIO(content))
