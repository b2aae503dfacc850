"""Writes a dataset in another library's layout."""

import importlib
import io
import json
import os
import tarfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pyarrow as pa

from magicsim.config.documents import without_nan
from magicsim.dataset.export.source import BYTES, MATRIX, Source, numbers, open_dataset
from magicsim.errors import ConfigError, OutputError
from magicsim.folder import new_folder

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
    with new_folder(out) as partial:
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
    from magicsim.dataset.export.arrays import write_hdf5, write_zarr

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
            _add(archive, f"{key}.{name}.npy", _npy(arrays[place]))
        _add(archive, f"{key}.json", json.dumps(without_nan(row), allow_nan=False).encode())


def _npy(array: np.ndarray[Any, Any]) -> bytes:
    sink = io.BytesIO()
    np.save(sink, array)
    return sink.getvalue()


def _add(archive: tarfile.TarFile, name: str, content: bytes) -> None:
    member = tarfile.TarInfo(name)
    member.size = len(content)
    archive.addfile(member, io.BytesIO(content))
