"""Random errors in what networks learn from, like those of fast frames against true ones.

Errors grow with the change nearby. A model that has learned from exact frames takes them for touches elsewhere.
"""

from dataclasses import dataclass
from typing import Self

import torch
from torch.nn import functional

from magicsim.arrays import Index
from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.learn.samples import Samples

NEARBY_PX, SMOOTH_PX = 4, 3
"""Half widths of the squares over which a change is averaged, and in which errors are alike [px]."""
SHARES = (0.77, 0.56, 0.3)
"""Parts of the errors: of single pixels, of such squares, and of whole colours; their squares add to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbance:
    """Errors of one set of frames, drawn anew whenever they are learned from."""

    sizes: torch.Tensor
    """Root mean square of the errors at each place, in units of the full range, shape (n, 1, rows, columns)."""
    input_sd: torch.Tensor
    """What inputs are divided by, shape (3, 1, 1)."""

    @classmethod
    def of(cls, samples: Samples, config: ModelConfig, share: float) -> Self:
        """Errors of some share of the root mean square change around each place."""
        change = torch.from_numpy(samples.inputs("difference")).square().mean(-1)[:, None]
        sizes = share * _averaged(change, NEARBY_PX, NEARBY_PX).sqrt()
        return cls(sizes=sizes, input_sd=torch.tensor(config.input_sd[:3]).reshape(3, 1, 1))

    def added(self, images: torch.Tensor, rows: Index) -> torch.Tensor:
        """Frames with errors, as networks read them, shape (n, channels, rows, columns).

        Args:
            images: Frames of some rows without errors, of the same shape; the first three channels get them.
            rows: Their numbers, shape (n,).
        """
        shape = images[:, :3].shape
        whole, wide = (*shape[:2], 1, 1), (*shape[:2], shape[2] + 2 * SMOOTH_PX, shape[3] + 2 * SMOOTH_PX)
        smooth = (2 * SMOOTH_PX + 1) * _averaged(torch.randn(wide), SMOOTH_PX, 0)
        of_pixel, of_square, of_color = SHARES
        errors = of_pixel * torch.randn(shape) + of_square * smooth + of_color * torch.randn(whole)
        return torch.cat([images[:, :3] + self.sizes[rows] / self.input_sd * errors, images[:, 3:]], 1)


def _averaged(images: torch.Tensor, half: int, border: int) -> torch.Tensor:
    """Means over squares of a half width [px], at the borders over what is there of them; without borders fewer."""
    width = 2 * half + 1
    columns = functional.avg_pool2d(images, (width, 1), 1, (border, 0), count_include_pad=False)
    return functional.avg_pool2d(columns, (1, width), 1, (0, border), count_include_pad=False)
