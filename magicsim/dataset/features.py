"""Columns of a dataset, as Arrow stores them and as Hugging Face `datasets` reads them.

A file carries its features as JSON under the schema's key `huggingface`; an `Array2D` column is a nested list that also
names its extension type in the field's metadata, without which it would be read as plain lists.
"""

import json
import math
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

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


def schema_of_columns(columns: list[Column]) -> pa.Schema:
    """Arrow schema that `datasets` reads with the right features."""
    features = {column.name: column.feature for column in columns}
    metadata = {"huggingface": json.dumps({"info": {"features": features}})}
    return pa.schema([column.field() for column in columns], metadata=metadata)


def _plain(dtype: str) -> pa.DataType:
    return pa.bool_() if dtype == "bool" else pa.type_for_alias(dtype)


def _value(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "_type": "Value"}
