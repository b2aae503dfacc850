"""Frames as pictures inside a page."""

import base64
import io

from PIL import Image

from magicsim.arrays import Frame

_QUALITY = 90


def webp_bytes(image: Frame) -> bytes:
    """A frame as a WebP picture, shape (rows, columns, 3)."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="WEBP", quality=_QUALITY, method=4)
    return buffer.getvalue()


def data_uri(image: Frame) -> str:
    """A frame as an address that holds the picture itself, shape (rows, columns, 3)."""
    return "data:image/webp;base64," + base64.b64encode(webp_bytes(image)).decode("ascii")
