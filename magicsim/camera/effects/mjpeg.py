"""A frame as JPEG leaves it."""

import cv2
import numpy as np

from magicsim.arrays import Frame
from magicsim.camera.settings import Mjpeg

SAMPLING = {
    "444": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "422": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "420": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}


def through_mjpeg(frame: Frame, mjpeg: Mjpeg) -> Frame:
    """The frame compressed and decompressed.

    Args:
        frame: RGB, shape (rows, columns, 3).
        mjpeg: Quality and sampling of the colours.
    """
    options = [cv2.IMWRITE_JPEG_QUALITY, mjpeg.quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, SAMPLING[mjpeg.chroma]]
    packed = cv2.imencode(".jpg", np.ascontiguousarray(frame[..., ::-1]), options)[1]
    unpacked = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
    return np.ascontiguousarray(unpacked[..., ::-1])
