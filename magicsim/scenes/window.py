"""Part of an image: a rectangle of whole pixels."""

from dataclasses import dataclass
from typing import Any, Self


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

    def of(self, image: Any) -> Any:
        """That part of an image, shape (rows, columns, ...)."""
        return image[self.row : self.row + self.rows, self.column : self.column + self.columns]
