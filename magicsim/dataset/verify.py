"""Checks a dataset's folder against its manifest: every hash, every row, every image."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.manifest import MANIFEST, Manifest, ShardEntry, read_manifest
from magicsim.dataset.shard import sha256_of
from magicsim.errors import OutputError

BALANCE = 1e-6
"""Largest relative difference between contact force and reaction, as the solver accepts it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What `magicsim dataset verify` reports."""

    samples: int
    """Rows in shards that are whole."""
    shards: int
    failed: int
    """Episodes without rows, as the manifest lists them."""
    complete: bool
    """Whether the dataset holds all that its recipe asks for."""
    problems: list[str]
    """One line for each; empty where the dataset is as it was written."""


def verify_dataset(folder: Path) -> Verification:
    """Reads everything.

    Raises:
        OutputError: The folder holds no dataset.
    """
    manifest = read_manifest(folder)
    if manifest is None:
        msg = f"'{folder}' holds no dataset: {MANIFEST} is missing"
        raise OutputError(msg)
    problems = [*_files(folder, manifest), *_strangers(folder, manifest)]
    samples = 0
    for entry in manifest.shards:
        found = list(_shard(folder, entry, manifest.config_hash))
        samples += entry.rows if not found else 0
        problems += found
    if sum(entry.rows for entry in manifest.shards) != manifest.rows:
        problems.append(f"{MANIFEST}: rows = {manifest.rows} is not the sum over its shards")
    return Verification(
        samples=samples,
        shards=len(manifest.shards),
        failed=len(manifest.failed),
        complete=manifest.is_complete,
        problems=problems,
    )


def _files(folder: Path, manifest: Manifest) -> Iterator[str]:
    for name, digest in manifest.files.items():
        if not (folder / name).is_file():
            yield f"{name}: missing"
        elif sha256_of(folder / name) != digest:
            yield f"{name}: changed since it was written (SHA-256 differs)"


def _strangers(folder: Path, manifest: Manifest) -> Iterator[str]:
    known = {entry.file for entry in manifest.shards}
    for path in sorted((folder / "data").glob("*.parquet")):
        name = path.relative_to(folder).as_posix()
        if name not in known:
            yield f"{name}: not in the manifest" + ("" if manifest.is_complete else " yet; --resume finishes it")


def _shard(folder: Path, entry: ShardEntry, config_hash: str) -> Iterator[str]:
    path = folder / entry.file
    if not path.is_file():
        yield f"{entry.file}: missing"
        return
    if path.stat().st_size != entry.size or sha256_of(path) != entry.sha256:
        yield f"{entry.file}: changed since it was written (SHA-256 differs)"
        return
    try:
        with pq.ParquetFile(path) as file:
            yield from (f"{entry.file}: {problem}" for problem in _rows(file, entry, config_hash))
    except (pa.ArrowException, OSError, KeyError) as error:
        yield f"{entry.file}: cannot be read: {' '.join(str(error).split())}"


def _rows(file: pq.ParquetFile, entry: ShardEntry, config_hash: str) -> Iterator[str]:
    plain = ["episode", "step", "config_hash", "contact", "force_n", "force_balance", "min_jacobian"]
    table = file.read(columns=[name for name in plain if name in file.schema_arrow.names])
    episodes = table["episode"].to_pylist()
    if tuple(sorted(set(episodes))) != entry.episodes or table.num_rows != entry.rows:
        yield f"holds {table.num_rows} rows of episodes {sorted(set(episodes))}, not what the manifest lists"
    if set(table["config_hash"].to_pylist()) - {config_hash}:
        yield "holds rows of another recipe"
    if "force_n" in table.column_names:
        force = np.array(table["force_n"].to_pylist())
        if not np.isfinite(force).all() or (np.array(table["force_balance"]) > BALANCE).any():
            yield "holds rows whose force is not finite or not balanced"
        if ((np.linalg.norm(force, axis=1) > 0) != np.array(table["contact"])).any():
            yield "holds rows whose contact flag contradicts their force"
    for number in range(file.num_row_groups):
        for name in ("image", "contact_mask"):
            if name in file.schema_arrow.names:
                images = file.read_row_group(number, columns=[name])[name].to_pylist()
                if any(not _decodes(each["bytes"]) for each in images):
                    yield f"{name}: a PNG of row group {number} cannot be decoded"


def _decodes(png: bytes) -> bool:
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED) is not None
