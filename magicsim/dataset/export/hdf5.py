"""HDF5: one file a split, one array a column (h5py)."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from magicsim.dataset.export.arrays import array_specs, fill
from magicsim.dataset.export.source import Source

COMPRESSION = 4
"""Level of gzip, 0..9."""


def write_hdf5(source: Source, folder: Path) -> None:
    """Writes `<split>.h5`; each array carries its meaning as the attribute `description`."""
    for split in source.splits:
        with h5py.File(folder / f"{split}.h5", "w", track_order=True) as file:
            file.attrs["config_hash"] = source.manifest.config_hash
            file.attrs["config"] = source.config_text
            for spec in array_specs(source):
                is_text, rows = spec.dtype == "string", source.rows(split)
                array = file.create_dataset(
                    spec.name,
                    (rows, *spec.shape),
                    h5py.string_dtype() if is_text else np.dtype(spec.dtype),
                    chunks=spec.chunks(rows),
                    compression=COMPRESSION,
                )
                array.attrs["description"] = spec.meaning

            def put(name: str, rows: slice, values: Any, file: h5py.File = file) -> None:  # noqa: ANN401
                file[name][rows] = values

            fill(source, split, put)
