"""Zarr 3: one group a split in one store, one array a column."""

from pathlib import Path
from typing import Any

import numpy as np
import zarr

from magicsim.dataset.export.arrays import array_specs, fill
from magicsim.dataset.export.source import Source


def write_zarr(source: Source, folder: Path) -> None:
    """Writes a group for each split; texts are its attribute `texts`, because Zarr 3 has no standard type for them."""
    root = zarr.open_group(folder, mode="w", zarr_format=3)
    root.attrs["config_hash"] = source.manifest.config_hash
    root.attrs["config"] = source.config_text
    for split in source.splits:
        group, rows = root.create_group(split), source.rows(split)
        texts: dict[str, list[str]] = {}
        for spec in array_specs(source):
            if spec.dtype == "string":
                texts[spec.name] = []
                continue
            array = group.create_array(
                spec.name,
                shape=(rows, *spec.shape),
                dtype=np.dtype(spec.dtype),
                chunks=spec.chunks(rows),
            )
            array.attrs["description"] = spec.meaning

        def put(name: str, place: slice, values: Any, group: Any = group, texts: Any = texts) -> None:  # noqa: ANN401
            if name in texts:
                texts[name].extend(values)
            else:
                group[name][place] = values

        fill(source, split, put)
        group.attrs["texts"] = texts
