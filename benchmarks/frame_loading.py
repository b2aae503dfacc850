"""How many rows a second `magicsim.dataset.torch` gives to a training loop, with frames of the demo.

magicsim simulate demo --out demo
python benchmarks/frame_loading.py demo        # a minute; needs the extra `learn`
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import torch
from torch.utils.data import DataLoader

from magicsim.dataset.frames import FrameTable
from magicsim.dataset.shard import Column, image, value, vector
from magicsim.dataset.torch import TouchDataset

COLUMNS: tuple[Column, ...] = (
    image("image", ""), image("contact_mask", ""), vector("force_n", 3, ""), vector("torque_nmm", 3, ""),
    value("depth_mm", "float64", ""), value("contact", "bool", ""),
)  # fmt: skip
REPEATED, BATCH, SECONDS, SINGLE = 20, 32, 12.0, 300
"""How often the run's frames stand in the table, rows of a batch, time of each measurement [s], rows that are timed
one by one."""


def table_of(run: Path, keep: Path) -> FrameTable:
    """A run's frames as a dataset's, in a file below `keep`."""
    rows = pq.read_table(run / "episode.parquet").to_pylist()
    for row in rows:
        row["image"] = {"bytes": (run / row["file"]).read_bytes(), "path": None}
    schema = pa.schema([pa.field(each.name, each.arrow) for each in COLUMNS])
    arrays = [pa.array([row[each.name] for row in rows], each.arrow) for each in COLUMNS]
    path = keep / "frames.arrow"
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_file(sink, schema) as writer:
        for _ in range(REPEATED):
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
    count = REPEATED * len(rows)
    return FrameTable(columns=COLUMNS, rows=np.arange(count), split_of=np.full(count, "train"), path=path)


def rows_a_second(samples: TouchDataset, *, workers: int) -> float:
    """Shuffled rows a second, from when the workers have started."""
    loader = DataLoader(samples, BATCH, shuffle=True, num_workers=workers, drop_last=True)
    batches = iter(loader)
    next(batches)  # waits for the processes
    rows, begin = 0, time.perf_counter()
    while time.perf_counter() - begin < SECONDS:
        batch = next(batches, None)
        if batch is None:
            break
        rows += len(batch["force_n"])
    return rows / (time.perf_counter() - begin)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="what `magicsim simulate demo --out` wrote")
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as keep:
        frames = table_of(parser.parse_args().run, Path(keep))
        samples = TouchDataset(frames)
        begin = time.process_time()
        for number in range(SINGLE):
            samples[number]
        found = {
            "processor_ms_a_row": round(1e3 * (time.process_time() - begin) / SINGLE, 2),
            "rows": len(frames),
            "image": list(frames[0]["image"].shape),
            "bytes_a_row": round(frames.path.stat().st_size / len(frames)),
            "rows_a_second": {str(count): round(rows_a_second(samples, workers=count)) for count in (0, 2)},
        }
    sys.stdout.write(json.dumps(found, indent=2) + "\n")
