"""Opens an export with `lerobot` itself and checks what it gives: `python read_export.py FOLDER`.

It runs where lerobot is installed and magicsim is not, so it needs nothing of magicsim.
"""

import json
import sys
from pathlib import Path

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

if __name__ == "__main__":
    root = Path(sys.argv[1])
    info = json.loads((root / "meta" / "info.json").read_text())
    frames = LeRobotDataset("magicsim/export", root=root)
    assert frames.num_frames == len(frames) == info["total_frames"]
    assert frames.num_episodes == info["total_episodes"]
    assert frames.fps == info["fps"]
    rows, columns, _ = info["features"]["observation.images.tactile"]["shape"]
    for number in (0, len(frames) - 1):
        frame = frames[number]
        assert frame["observation.images.tactile"].shape == (3, rows, columns)
        assert frame["observation.state"].shape == (len(info["features"]["observation.state"]["names"]),)
        assert frame["task"] in {"touch", "flashlight"}
    batch = next(iter(torch.utils.data.DataLoader(frames, batch_size=4)))
    assert batch["observation.images.tactile"].shape == (4, 3, rows, columns)
    sys.stdout.write(f"{len(frames)} frames of {frames.num_episodes} episodes at {frames.fps} frames a second\n")
