"""WebDataset: tar files whose members share the name of their sample."""

import io
import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from magicsim.config.plain import without_nan
from magicsim.dataset.export.source import BYTES, MATRIX, Source, numbers

ENDINGS = {"image": "png", "contact_mask": "mask.png"}


def write_webdataset(source: Source, folder: Path) -> None:
    """Writes `<split>-NNNNNN.tar`, one for each shard; plain columns are in `json`, matrices in `<column>.npy`."""
    for split in source.splits:
        for number, shard in enumerate(source.shards(split)):
            with tarfile.open(folder / f"{split}-{number:06d}.tar", "w") as archive:
                for table in source.episodes(shard):
                    _episode(archive, source, table)


def _episode(archive: tarfile.TarFile, source: Source, table: pa.Table) -> None:
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
