"""`cv2.VideoCapture` on a simulated sensor: the same calls, the same results, no device.

Images are BGR uint8, shape (rows, columns, 3), in the orientation of all magicsim frames: row 0 at +y, column 0 at -x,
so 240 x 320 (width x height) by default. Reading never waits: time is the simulation's, one frame further at every
grab. Like the original, a method of a closed capture answers False or -1 and does not raise.
"""

from collections.abc import Callable

import cv2
import numpy as np

from magicsim.arrays import Frame
from magicsim.errors import ConfigError
from magicsim.robot.darkroom import Moment
from magicsim.robot.live import LiveSensor


def as_bgr(rgb: Frame) -> Frame:
    """A picture with its channels in OpenCV's order, in memory of its own, shape (rows, columns, 3)."""
    return np.ascontiguousarray(rgb[..., ::-1])


def as_landscape(portrait: Frame) -> Frame:
    """The picture turned clockwise by 90 degrees: row 0 at -x, column 0 at -y; shape (columns, rows, 3)."""
    return np.ascontiguousarray(np.rot90(portrait, -1))


World = Callable[[LiveSensor, float], None]
"""Called before every grabbed frame with the sensor and the simulated time [s]: moves object and lights."""


class SimulatedCapture:
    """What `cv2.VideoCapture(0)` would be with the sensor plugged in."""

    def __init__(self, sensor: LiveSensor, *, world: World | None = None) -> None:
        """Opens a stream.

        Args:
            sensor: Moved by its owner, before or between frames; releasing the capture leaves it open.
            world: Moves it as time passes, for code that only reads.
        """
        self._sensor = sensor
        self._world = world
        self._is_open = not sensor.is_closed
        self._grabbed: Moment | None = None
        self._converts_rgb = True

    def isOpened(self) -> bool:
        """Whether frames can be read."""
        return self._is_open and not self._sensor.is_closed

    def open(self, *_source: object) -> bool:
        """Opens the stream of the same sensor again, whatever the source; whether that succeeded."""
        self._is_open = not self._sensor.is_closed
        return self._is_open

    def release(self) -> None:
        """Closes the stream; may be called again."""
        self._is_open, self._grabbed = False, None

    def grab(self) -> bool:
        """Takes the next frame without rendering it; whether there was one."""
        if not self.isOpened():
            self._grabbed = None
            return False
        if self._world is not None:
            self._world(self._sensor, self._sensor.time_s)
        self._grabbed = self._sensor.grab()
        return True

    def retrieve(self, image: Frame | None = None, flag: int = 0) -> tuple[bool, Frame | None]:
        """The grabbed frame, as often as asked for.

        Args:
            image: An array of the same shape that takes the frame, as in OpenCV; otherwise a new one.
            flag: Channel of a device with several; there is only 0.

        Returns:
            Whether there is a frame, and the frame or None.
        """
        if self._grabbed is None or flag != 0 or not self.isOpened():
            return False, None
        rgb = self._sensor.develop(self._grabbed).image
        frame = as_bgr(rgb) if self._converts_rgb else rgb
        if image is None or image.shape != frame.shape or image.dtype != np.uint8:
            return True, frame
        image[...] = frame
        return True, image

    def read(self, image: Frame | None = None) -> tuple[bool, Frame | None]:
        """Grabs and retrieves."""
        return self.retrieve(image) if self.grab() else (False, None)

    def get(self, propId: int) -> float:
        """A property by OpenCV's number; 0 for those that the sensor does not have, -1 when closed."""
        if not self.isOpened():
            return -1.0
        window = self._sensor.sensor.rig.camera.window
        values = {
            cv2.CAP_PROP_FRAME_WIDTH: window.columns,
            cv2.CAP_PROP_FRAME_HEIGHT: window.rows,
            cv2.CAP_PROP_FPS: self._sensor.frames_per_second,
            cv2.CAP_PROP_POS_FRAMES: self._sensor.frame_index,
            cv2.CAP_PROP_POS_MSEC: 1000 * self._sensor.time_s,
            cv2.CAP_PROP_FORMAT: cv2.CV_8UC3,
            cv2.CAP_PROP_CONVERT_RGB: self._converts_rgb,
        }
        return float(values.get(propId, 0.0))

    def set(self, propId: int, value: float) -> bool:
        """Sets image size, frame rate or `CAP_PROP_CONVERT_RGB`; whether it was accepted.

        `CAP_PROP_CONVERT_RGB` 0 gives the camera's own RGB instead of BGR.
        """
        if not self.isOpened():
            return False
        camera = self._sensor.sensor.rig.camera
        try:
            if propId == cv2.CAP_PROP_FRAME_WIDTH:
                self._sensor.set_image_size(columns=round(value), rows=camera.rows)
            elif propId == cv2.CAP_PROP_FRAME_HEIGHT:
                self._sensor.set_image_size(columns=camera.columns, rows=round(value))
            elif propId == cv2.CAP_PROP_FPS:
                self._sensor.set_frame_rate(value)
            elif propId == cv2.CAP_PROP_CONVERT_RGB:
                self._converts_rgb = bool(value)
            else:
                return False
        except (ConfigError, OverflowError, ValueError):
            return False
        return True

    def getBackendName(self) -> str:
        """Which driver reads the frames."""
        return "MAGICSIM"
