"""Part of an image: a rectangle of whole pixels."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt


@dataclass(slots=True, kw_only=True)
class Window:
    """Columns and rows from a first one."""

    column: int
    row: int
    columns: int
    rows: int

    @classmethod
    def whole(cls, columns: int, rows: int) -> Self:
        """The whole image."""
        return cls(column=0, row=0, columns=columns, rows=rows)

    def grown(self, margin: int, columns: int, rows: int) -> Self:
        """With a margin on each side, as far as the image of so many columns and rows goes."""
        left, top = max(0, self.column - margin), max(0, self.row - margin)
        right, bottom = min(columns, self.column + self.columns + margin), min(rows, self.row + self.rows + margin)
        return replace(self, column=left, row=top, columns=right - left, rows=bottom - top)

    def within(self, other: Self) -> Self:
        """These pixels, counted from the first ones of another window."""
        return replace(self, column=self.column - other.column, row=self.row - other.row)

    def numbers(self, columns: int, rows: int) -> npt.NDArray[np.uint32]:
        """Numbers of its pixels in an image of so many columns and rows, counted row by row; shape (pixels,)."""
        return np.asarray(self.of(np.arange(columns * rows, dtype=np.uint32).reshape(rows, columns)).ravel())

    def of(self, image: Any) -> Any:
        """That part of an image, shape (rows, columns, ...)."""
        return image[self.row : self.row + self.rows, self.column : self.column + self.columns]
