"""How many rows a second `magicsim.dataset.torch` gives to a training loop.

magicsim dataset default --out touches --set episodes=4
python benchmarks/frame_loading.py touches    # a minute; needs the extra `learn`
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import torch
from torch.utils.data import DataLoader

from magicsim.dataset.frames import open_frames
from magicsim.dataset.torch import TouchDataset

COLUMNS = ("image", "contact_mask", "force_n", "torque_nmm", "depth_mm", "contact")
BATCH, SECONDS = 32, 15.0


def rows_a_second(samples: TouchDataset, *, workers: int) -> float:
    """Shuffled rows a second, from when the workers have started."""
    loader = DataLoader(
        samples, BATCH, shuffle=True, num_workers=workers, persistent_workers=workers > 0, drop_last=True
    )
    rows = 0
    begin = None
    while begin is None or time.perf_counter() - begin < SECONDS:
        for batch in loader:
            if begin is None:
                begin = time.perf_counter()  # the first batch waits for the processes
                continue
            rows += len(batch["force_n"])
            if time.perf_counter() - begin > SECONDS:
                break
    return rows / (time.perf_counter() - begin)


def main() -> None:
    """Measures a dataset."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="a dataset of magicsim")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as keep:
        begin = time.perf_counter()
        frames = open_frames(options.folder, COLUMNS, keep=Path(keep))
        opened_s = time.perf_counter() - begin
        image = frames[0]["image"]
        size = frames.path.stat().st_size
        found = {
            "rows": len(frames), "image": list(image.shape), "bytes_a_row": round(size / len(frames)),
            "seconds_to_open_first": round(opened_s, 2), "batch": BATCH,
            "rows_a_second": {
                str(workers): round(rows_a_second(TouchDataset(frames), workers=workers), 1) for workers in (0, 1, 2)
            },
        }  # fmt: skip
    text = json.dumps(found, indent=2)
    if options.out is not None:
        options.out.write_text(f"{text}\n", encoding="utf-8")
    sys.stdout.write(f"{text}\n")


if __name__ == "__main__":
    main()
