"""What arrays of numbers are called in annotations; shapes and units stand in docstrings."""

from typing import Any

import numpy as np
import numpy.typing as npt

AnyArray = npt.NDArray[Any]
Array = npt.NDArray[np.float64]
FloatImage = npt.NDArray[np.float32]
"""Linear radiance, shape (rows, columns, 3)."""
Frame = npt.NDArray[np.uint8]
"""What a camera gives, RGB, shape (rows, columns, 3)."""
Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Counts = npt.NDArray[np.uint64]
Numbers = npt.NDArray[np.uint32]
"""What kernels number things by."""
Indices = npt.NDArray[np.int32]
"""What sparse matrices number their entries by."""
