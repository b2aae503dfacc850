"""LeRobot's dataset layout, version 3.0, with images instead of video: frames stay what they were.

Files: `meta/info.json`, `meta/stats.json`, `meta/tasks.parquet`, `meta/episodes/`, `data/`. Written from its documented
layout; the package itself is not needed.
"""

import json
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import AnyArray
from magicsim.dataset.export.source import Source
from magicsim.dataset.shard import Column, image, schema_of_columns

IMAGE, STATE = "observation.images.tactile", "observation.state"
STATE_NAMES = (
    "force_x_n", "force_y_n", "force_z_n", "torque_x_nmm", "torque_y_nmm", "torque_z_nmm", "depth_mm",
    "contact_area_mm2", "contact",
)  # fmt: skip
COUNTERS = ("frame_index", "episode_index", "index", "task_index")
FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
FILES_A_CHUNK = 1000


Moments = tuple[int, AnyArray, AnyArray, AnyArray, AnyArray]
"""Running statistics of one feature: count, least, largest, sum, and sum of squares, each of shape (components,)."""


def _moments_of(values: AnyArray) -> Moments:
    """Statistics of values of shape (samples, components)."""
    wide = values.astype(np.float64)
    return len(wide), wide.min(0), wide.max(0), wide.sum(0), (wide**2).sum(0)


def _together(one: Moments, other: Moments) -> Moments:
    sums = (one[3] + other[3], one[4] + other[4])
    return one[0] + other[0], np.minimum(one[1], other[1]), np.maximum(one[2], other[2]), *sums


def write_lerobot(source: Source, folder: Path) -> None:
    """Writes the layout; the splits follow each other, and a task is a kind of path."""
    paths: list[str] = sorted({kind.kind for kind in source.recipe.paths})
    columns = _columns()
    schema = schema_of_columns(columns)
    episodes: list[dict[str, Any]] = []
    whole: dict[str, Moments] = {}
    splits: dict[str, str] = {}
    first, files = 0, count()
    for split in source.splits:
        begun = len(episodes)
        for shard in source.shards(split):
            chunk, number = divmod(next(files), FILES_A_CHUNK)
            path = folder / "data" / FILE.format(chunk_index=chunk, file_index=number)
            path.parent.mkdir(parents=True, exist_ok=True)
            with pq.ParquetWriter(path, schema, compression="zstd") as writer:
                for table in source.episodes(shard):
                    rows = _rows(table, len(episodes), first, paths)
                    moments = _moments(rows, source.pictures(table, "image"))
                    whole = {name: _together(whole[name], each) if whole else each for name, each in moments.items()}
                    arrays = [pa.array(rows[column.name], column.arrow) for column in columns]
                    writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
                    episodes.append(_episode(table, len(episodes), first, (chunk, number), moments))
                    first += table.num_rows
        splits[split] = f"{begun}:{len(episodes)}"
    _write_meta(folder / "meta", source, episodes, whole, splits, paths, first)


def _columns() -> list[Column]:
    value = {"dtype": "float32", "_type": "Value"}
    length = len(STATE_NAMES)
    state = {"feature": value, "length": length, "_type": "Sequence"}
    counter = {"dtype": "int64", "_type": "Value"}
    return [
        image(IMAGE, "frame"),
        Column(name=STATE, arrow=pa.list_(pa.float32(), length), feature=state, meaning="truth"),
        Column(name="timestamp", arrow=pa.float32(), feature=value, meaning="time [s]"),
        *(Column(name=name, arrow=pa.int64(), feature=counter, meaning="counter") for name in COUNTERS),
    ]


def _rows(table: pa.Table, episode: int, first: int, paths: list[str]) -> dict[str, Any]:
    length = table.num_rows
    parts = [
        np.array(table["force_n"].to_pylist()),
        np.array(table["torque_nmm"].to_pylist()),
        *(np.array(table[name].to_pylist(), float)[:, None] for name in ("depth_mm", "contact_area_mm2", "contact")),
    ]
    return {
        IMAGE: table["image"].to_pylist(),
        STATE: list(np.concatenate(parts, 1).astype(np.float32)),
        "timestamp": table["time_s"].to_pylist(),
        "frame_index": list(range(length)),
        "episode_index": [episode] * length,
        "index": list(range(first, first + length)),
        "task_index": [paths.index(kind) for kind in table["path_kind"].to_pylist()],
    }


def _moments(rows: dict[str, Any], frames: list[npt.NDArray[np.uint8]]) -> dict[str, Moments]:
    pixels = np.concatenate([each.reshape(-1, 3) for each in frames]) / 255
    moments = {IMAGE: _moments_of(pixels), STATE: _moments_of(np.stack(rows[STATE]))}
    return moments | {name: _moments_of(np.array(rows[name])[:, None]) for name in ("timestamp", *COUNTERS)}


def _stats(moments: dict[str, Moments], frames: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """The layout's words for them, each of its feature's shape."""
    for name, (size, low, high, total, squares) in moments.items():
        mean, shape = total / size, (3, 1, 1) if name == IMAGE else (-1,)
        deviation = np.sqrt(np.maximum(squares / size - mean**2, 0))
        named = {"min": low, "max": high, "mean": mean, "std": deviation}
        yield name, {key: value.reshape(shape).tolist() for key, value in named.items()} | {"count": [frames]}


def _episode(
    table: pa.Table, number: int, first: int, file: tuple[int, int], moments: dict[str, Moments]
) -> dict[str, Any]:
    stats = {
        f"stats/{name}/{key}": value for name, each in _stats(moments, table.num_rows) for key, value in each.items()
    }
    return {
        "episode_index": number,
        "tasks": [table["path_kind"][0].as_py()],
        "length": table.num_rows,
        "dataset_from_index": first,
        "dataset_to_index": first + table.num_rows,
        "data/chunk_index": file[0],
        "data/file_index": file[1],
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
    } | stats


def _write_meta(
    folder: Path,
    source: Source,
    episodes: list[dict[str, Any]],
    moments: dict[str, Moments],
    splits: dict[str, str],
    paths: list[str],
    frames: int,
) -> None:
    fps, shape = source.recipe.frames_per_second, [*source.frame_size, 3]
    info = {
        "codebase_version": "v3.0",
        "robot_type": "mini-magictac",
        "total_episodes": len(episodes),
        "total_frames": frames,
        "total_tasks": len(paths),
        "chunks_size": FILES_A_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": int(fps) if float(fps).is_integer() else fps,
        "splits": splits,
        "data_path": f"data/{FILE}",
        "video_path": None,
        "features": {
            IMAGE: {"dtype": "image", "shape": shape, "names": ["height", "width", "channels"]},
            STATE: {"dtype": "float32", "shape": [len(STATE_NAMES)], "names": list(STATE_NAMES)},
            "timestamp": {"dtype": "float32", "shape": [1], "names": None},
            **{name: {"dtype": "int64", "shape": [1], "names": None} for name in COUNTERS},
        },
    }
    (folder / "episodes" / "chunk-000").mkdir(parents=True)
    (folder / "info.json").write_text(json.dumps(info, indent=4), encoding="utf-8")
    (folder / "stats.json").write_text(json.dumps(dict(_stats(moments, frames)), indent=4), encoding="utf-8")
    pq.write_table(pa.Table.from_pylist(episodes), folder / "episodes" / FILE.format(chunk_index=0, file_index=0))
    tasks = pa.table({"task_index": pa.array(range(len(paths)), pa.int64()), "task": paths})
    described = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_type, "metadata": None}
        for name, kind, numpy_type in (("task_index", "int64", "int64"), ("task", "unicode", "object"))
    ]
    index = {"index_columns": ["task"], "columns": described, "column_indexes": [], "pandas_version": "2.0.0"}
    pq.write_table(tasks.replace_schema_metadata({"pandas": json.dumps(index)}), folder / "tasks.parquet")
