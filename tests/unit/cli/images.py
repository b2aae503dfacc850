"""Images that a test of the detectors' command needs."""

from pathlib import Path

import cv2
import numpy as np


def write_frames(folder: Path, count: int, *, rows: int = 32, columns: int = 24) -> Path:
    """Images of a dark grid on a bright ground."""
    folder.mkdir()
    row, column = np.indices((rows, columns))
    image = np.where((row % 6 < 2) | (column % 6 < 2), 10, 80).astype(np.uint8)
    for number in range(count):
        assert cv2.imwrite(str(folder / f"{number:03d}.png"), np.dstack([image] * 3))
    return folder
