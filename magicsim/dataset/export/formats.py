"""Writes a dataset in another library's layout."""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from magicsim.dataset.export.source import Source, open_dataset
from magicsim.errors import ConfigError, OutputError
from magicsim.folder import new_folder

Format = Literal["lerobot", "webdataset", "hdf5", "mcap", "zarr"]
OF_SIMULATED = frozenset({"lerobot", "mcap"})
"""Layouts that hold the camera's calibration or every frame's contact, which recordings lack."""


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

    Args:
        folder: The dataset.
        out: New folder, there only once it is whole.
        layout: Which library's.

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
        msg = f"output folder '{out}' is inside of the dataset '{folder}'; name a folder elsewhere"
        raise OutputError(msg)
    if out.exists():
        msg = f"output folder '{out}' exists; name a new folder"
        raise OutputError(msg)
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
        if layout == "lerobot":
            from magicsim.dataset.export.lerobot import write_lerobot as writer
        elif layout == "webdataset":
            from magicsim.dataset.export.webdataset import write_webdataset as writer
        elif layout == "hdf5":
            from magicsim.dataset.export.hdf5 import write_hdf5 as writer
        elif layout == "mcap":
            from magicsim.dataset.export.mcap import write_mcap as writer
        else:
            from magicsim.dataset.export.zarr import write_zarr as writer
    except ImportError as error:
        msg = f"format '{layout}' needs the package {error.name}: pip install 'magicsim[{layout}]'"
        raise ConfigError(msg) from None
    return writer
