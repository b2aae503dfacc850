"""Pictures in a dataset's rows: PNG, decoded or found damaged without a decoder printing about it."""

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.sources.image_header import HEAD_BYTES, MAX_PIXELS, image_size
from magicsim.detectors.sources.png_check import SIGNATURE, is_damaged_png


def decoded_png(content: object) -> npt.NDArray[Any] | None:
    """Pixels of a PNG: (rows, columns, 3) RGB of a frame, (rows, columns) of a mask; None where it cannot be decoded.

    Args:
        content: Its bytes; anything else is no picture.
    """
    if not isinstance(content, bytes) or not content.startswith(SIGNATURE) or is_damaged_png(content):
        return None
    columns, rows = image_size(content[:HEAD_BYTES]) or (0, 0)
    if not 0 < columns * rows <= MAX_PIXELS:
        return None
    found = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if found is None or found.dtype != np.uint8:
        return None
    if found.ndim == 2:  # noqa: PLR2004
        return found
    return cv2.cvtColor(found, cv2.COLOR_BGR2RGB) if found.shape[2] == 3 else None  # noqa: PLR2004
