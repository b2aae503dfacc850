"""Parquet files of a dataset: what bytes rows become, how they are read, and the pictures in them."""

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.manifest import MANIFEST, ShardEntry, listed_content
from magicsim.detectors.source import SIGNATURE, is_damaged_png
from magicsim.errors import OutputError

ROWS_A_GROUP = 100
"""Most rows in a row group: what a reader of single rows has to decode."""
SPLIT_STREAMS = ("depth_map_mm.list.element.list.element", "displacements_mm.list.element.list.element")
"""Columns of numbers that compress better byte by byte."""
NOT_REPEATED = frozenset({*SPLIT_STREAMS, "image.bytes", "contact_mask.bytes"})


def write_rows(target: Path | io.BytesIO, tables: Iterable[pa.Table], schema: pa.Schema) -> int:
    """Writes tables of one schema as a Parquet file; the bytes depend on their content alone.

    Returns:
        Number of rows.
    """
    leaves = [column.path for column in _leaves(schema)]
    rows = 0
    with pq.ParquetWriter(
        target,
        schema,
        compression="zstd",
        use_dictionary=[name for name in leaves if name not in NOT_REPEATED],
        use_byte_stream_split=[name for name in leaves if name in SPLIT_STREAMS],
        write_page_index=True,
    ) as writer:
        for table in tables:
            writer.write_table(table, row_group_size=ROWS_A_GROUP)
            rows += table.num_rows
    return rows


def _leaves(schema: pa.Schema) -> list[pq.ColumnSchema]:
    sink = io.BytesIO()
    pq.write_table(schema.empty_table(), sink)
    parquet = pq.ParquetFile(io.BytesIO(sink.getvalue())).schema
    return [parquet.column(number) for number in range(len(parquet))]


def rows_as_bytes(table: pa.Table) -> bytes:
    """A table as a Parquet file in memory."""
    sink = io.BytesIO()
    write_rows(sink, [table], table.schema)
    return sink.getvalue()


def parquet_bytes(table: pa.Table) -> bytes:
    """A table that is no part of a dataset as a Parquet file in memory, in PyArrow's own layout."""
    sink = io.BytesIO()
    pq.write_table(table, sink, compression="zstd")
    return sink.getvalue()


def read_rows(path: Path) -> pa.Table:
    """A whole Parquet file, its extension metadata kept as it is."""
    with pq.ParquetFile(path) as file:
        return file.read()


def read_episodes(path: Path, wanted: set[int]) -> Iterator[tuple[int, pa.Table]]:
    """Rows of some episodes of a shard, one episode at a time."""
    if not wanted:
        return
    whole = read_rows(path)
    episodes = whole["episode"].to_pylist()
    for episode in sorted(wanted & set(episodes)):
        yield episode, whole.slice(episodes.index(episode), episodes.count(episode)).combine_chunks()


def read_shard(folder: Path, entry: ShardEntry, schema: pa.Schema) -> pa.Table:
    """Rows of a finished shard, whose bytes must be those that the manifest lists.

    Args:
        folder: Of the dataset.
        entry: The shard.
        schema: Of the result.

    Raises:
        OutputError: It is missing, has changed, or holds other rows or columns; the message names it.
    """
    content = listed_content(folder, entry.file, entry.listed)
    try:
        with pq.ParquetFile(pa.BufferReader(content)) as file:
            rows = as_schema(file.read(), schema)
    except (pa.ArrowException, OSError, KeyError, TypeError, ValueError) as error:
        reason = str(error.args[0] if error.args else error).partition("\n")[0]
        msg = f"'{folder / entry.file}' does not hold the rows of this dataset: {reason}"
        raise OutputError(msg) from None
    if rows.num_rows != entry.rows:
        msg = f"'{folder / entry.file}' holds {rows.num_rows} rows, and {MANIFEST} lists {entry.rows}"
        raise OutputError(msg)
    return rows


def as_schema(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """These rows under exactly this schema, whether or not some library has registered its extension types."""
    arrays = []
    for name in schema.names:
        chunk = table[name].combine_chunks()
        chunk = chunk.storage if isinstance(chunk, pa.ExtensionArray) else chunk
        arrays.append(chunk)
    return pa.Table.from_arrays(arrays, schema=schema)


def decoded_png(content: object) -> npt.NDArray[Any] | None:
    """Pixels of a PNG: (rows, columns, 3) RGB of a frame, (rows, columns) of a mask; None where it cannot be decoded.

    Args:
        content: Its bytes; anything else is no picture.
    """
    if not isinstance(content, bytes) or not content.startswith(SIGNATURE) or is_damaged_png(content):
        return None
    try:
        pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # larger than OpenCV may read
        return None
    if pixels is None or pixels.dtype != np.uint8:
        return None
    if pixels.ndim == 2:  # noqa: PLR2004
        return pixels
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB) if pixels.shape[2] == 3 else None  # noqa: PLR2004
