"""How rows of a dataset are stored: columns, Parquet files, and the pictures in them.

Arrow stores the columns, and Hugging Face `datasets` reads them. A file carries its features as JSON under the schema's
key `huggingface`; an `Array2D` column is a nested list that also names its extension type in the field's metadata,
without which it would be read as plain lists.
"""

import io
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.dataset.manifest import MANIFEST, ShardEntry, listed_content
from magicsim.detectors.picture import is_damaged_png
from magicsim.detectors.tags import SIGNATURE
from magicsim.errors import OutputError

ARRAY_2D = "datasets.features.features.Array2DExtensionType"


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column."""

    name: str
    arrow: pa.DataType
    feature: dict[str, Any]
    """What `datasets` calls it."""
    meaning: str
    """For the dataset card, with its unit."""
    metadata: dict[str, str] | None = None

    @property
    def empty(self) -> object:
        """What stands where there is nothing: an empty text, numbers that are none; None where neither serves."""
        kind = self.feature["_type"]
        if kind == "Sequence":
            return [math.nan] * self.feature["length"]
        dtype = self.feature.get("dtype", "")
        return "" if dtype == "string" else math.nan if kind == "Value" and dtype.startswith("float") else None

    def field(self) -> pa.Field:
        """Field of an Arrow schema."""
        return pa.field(self.name, self.arrow, metadata=self.metadata)


def value(name: str, dtype: str, meaning: str) -> Column:
    """A column of plain values: `float64`, `int32`, `bool`, `string` and so on."""
    return Column(name=name, arrow=_plain(dtype), feature=_value(dtype), meaning=meaning)


def vector(name: str, length: int, meaning: str) -> Column:
    """A column of vectors of one length."""
    feature = {"feature": _value("float64"), "length": length, "_type": "Sequence"}
    return Column(name=name, arrow=pa.list_(pa.float64(), length), feature=feature, meaning=meaning)


def image(name: str, meaning: str) -> Column:
    """A column of PNG images."""
    arrow = pa.struct({"bytes": pa.binary(), "path": pa.string()})
    return Column(name=name, arrow=arrow, feature={"_type": "Image"}, meaning=meaning)


def array(name: str, shape: tuple[int | None, int], meaning: str, *, dtype: str = "float32") -> Column:
    """A column of matrices; the first extent may be open."""
    return Column(
        name=name,
        arrow=pa.list_(pa.list_(_plain(dtype))),
        feature={"shape": list(shape), "dtype": dtype, "_type": "Array2D"},
        meaning=meaning,
        metadata={"ARROW:extension:name": ARRAY_2D, "ARROW:extension:metadata": json.dumps([list(shape), dtype])},
    )


def table_of_rows(rows: Sequence[Mapping[str, Any]], columns: Sequence[Column]) -> pa.Table:
    """Rows under the columns' schema; what a row lacks is empty there."""
    arrays = []
    for each in columns:
        values: list[Any] = [row[each.name] if row.get(each.name) is not None else each.empty for row in rows]
        is_matrix = each.feature["_type"] == "Array2D"
        arrays.append(_nested(values, each.arrow) if is_matrix else pa.array(values, each.arrow))
    return pa.Table.from_arrays(arrays, schema=schema_of_columns(columns))


def _nested(values: list[npt.ArrayLike], arrow: pa.DataType) -> pa.Array:
    """Matrices as lists of lists, without a Python object for each number."""
    matrices = [np.asarray(each) for each in values]
    flat = pa.array(np.concatenate([each.ravel() for each in matrices]), arrow.value_type.value_type)
    widths = np.concatenate([np.full(len(each), each.shape[1]) for each in matrices])
    lengths = [len(each) for each in matrices]
    inner = pa.ListArray.from_arrays(pa.array(np.concatenate([[0], np.cumsum(widths)]), pa.int32()), flat)
    return pa.ListArray.from_arrays(pa.array(np.concatenate([[0], np.cumsum(lengths)]), pa.int32()), inner)


def png_cell(pixels: npt.NDArray[np.uint8]) -> dict[str, Any]:
    """A cell of a column of images, from RGB pixels, shape (rows, columns, 3), or a mask, (rows, columns)."""
    shown = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR) if pixels.ndim == 3 else pixels  # noqa: PLR2004
    return {"bytes": cv2.imencode(".png", shown)[1].tobytes(), "path": None}


def schema_of_columns(columns: Sequence[Column]) -> pa.Schema:
    """Arrow schema that `datasets` reads with the right features."""
    features = {column.name: column.feature for column in columns}
    metadata = {"huggingface": json.dumps({"info": {"features": features}})}
    return pa.schema([column.field() for column in columns], metadata=metadata)


def _plain(dtype: str) -> pa.DataType:
    return pa.bool_() if dtype == "bool" else pa.type_for_alias(dtype)


def _value(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "_type": "Value"}


ROWS_A_GROUP = 100
"""Most rows in a row group: what a reader of single rows has to decode."""
SPLIT_STREAMS = ("depth_map_mm.list.element.list.element", "displacements_mm.list.element.list.element")
"""Columns of numbers that compress better byte by byte."""
NOT_REPEATED = frozenset({*SPLIT_STREAMS, "image.bytes", "contact_mask.bytes"})


def write_rows(target: Path | io.BytesIO, tables: Iterable[pa.Table], schema: pa.Schema) -> int:
    """Writes tables of one schema as a Parquet file, and counts rows; the bytes depend on their content alone."""
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
    """Rows of a finished shard; an `OutputError` names it where its bytes are not those that the manifest lists."""
    content = listed_content(folder, entry.file, entry.listed)
    try:
        with pq.ParquetFile(pa.BufferReader(content)) as file:
            rows = as_schema(file.read(), schema)
    except (pa.ArrowException, OSError, KeyError, TypeError, ValueError) as error:
        reason = str(error.args[0] if error.args else error).partition("\n")[0]
        raise OutputError(f"'{folder / entry.file}' does not hold the rows of this dataset: {reason}") from None
    if rows.num_rows != entry.rows:
        raise OutputError(f"'{folder / entry.file}' holds {rows.num_rows} rows, and {MANIFEST} lists {entry.rows}")
    return rows


def as_schema(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """These rows under exactly this schema, whether or not some library has registered its extension types."""
    return pa.Table.from_arrays([plain_column(table, name) for name in schema.names], schema=schema)


def plain_column(table: pa.Table, name: str) -> pa.Array:
    """A column in Arrow's own types."""
    column = table[name].combine_chunks()
    return column.storage if isinstance(column, pa.ExtensionArray) else column


def decoded_png(content: object) -> npt.NDArray[Any] | None:
    """Pixels of a PNG: (rows, columns, 3) RGB of a frame, (rows, columns) of a mask; None if it cannot be decoded."""
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
