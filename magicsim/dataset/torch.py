"""A dataset's frames as PyTorch takes them (extra `torch`): a map-style dataset for `torch.utils.data.DataLoader`.

frames = open_frames("touches")
parts = frames.split_by("unit", {"train": 0.8, "test": 0.2})
loader = DataLoader(TouchDataset(parts["train"]), batch_size=32, shuffle=True, num_workers=2)
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.errors import ConfigError

try:
    import torch
    from torch.utils.data import Dataset
except ImportError as error:
    raise ConfigError(f"magicsim.dataset.torch needs the package {error.name}: pip install 'magicsim[torch]'") from None

Sample = dict[str, Any]


class TouchDataset(Dataset[Sample]):
    """Rows of a dataset as tensors: images (3, rows, columns) uint8, masks (rows, columns) bool, the rest as it is.

    Numbers become float32, whole ones int64, flags bool; texts stay texts. Where there is nothing, a number
    is NaN and a text empty.
    """

    def __init__(self, frames: FrameTable | Path | str, *, transform: Callable[[Sample], Any] | None = None) -> None:
        """Takes rows.

        Args:
            frames: Of `open_frames`, or the folder of a dataset, which stands for all of its frames.
            transform: Called with each sample; what it returns is handed on.

        Raises:
            OutputError: There is no finished dataset.
        """
        self.frames = frames if isinstance(frames, FrameTable) else open_frames(frames)
        self.transform = transform

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, number: int) -> Any:  # noqa: ANN401 - what the transform returns
        cv2.setNumThreads(0)  # workers are processes; threads in them would fight for the same cores
        sample = {name: _tensor(value) for name, value in self.frames[number].items()}
        return self.transform(sample) if self.transform is not None else sample


def _tensor(value: Any) -> Any:  # noqa: ANN401 - as the column has them
    if isinstance(value, np.ndarray):
        if value.dtype == np.uint8:
            return torch.from_numpy(np.ascontiguousarray(value.transpose(2, 0, 1)))
        return torch.from_numpy(value if value.dtype == bool else value.astype(np.float32))
    if isinstance(value, bool):
        return torch.tensor(value)
    if isinstance(value, int):
        return torch.tensor(value, dtype=torch.int64)
    return torch.tensor(value, dtype=torch.float32) if isinstance(value, float) else value
