"""A DIGIT's public methods on a simulated sensor, so that code written for one runs unchanged on the simulator.

Written from the documented behaviour alone. Frames are BGR uint8 in portrait, shape (320, 240, 3) for the stream QVGA
and (640, 480, 3) for VGA: row 0 at the sensor's +y, column 0 at its -x, as in all of magicsim. The image sensor itself
lies on its side: `get_frame(transpose=True)` gives its own landscape picture, the portrait one turned clockwise by 90
degrees. Reading never waits: every frame lets one frame's time of the simulation pass. What the documentation leaves
open is stated at each method.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np

from magicsim.arrays import Frame
from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError, FrameError
from magicsim.folder import result_file
from magicsim.robot.capture import as_bgr, as_landscape
from magicsim.robot.live import LiveSensor
from magicsim.robot.picture import Picture


class DigitCamera:
    """A DIGIT by its public methods, on a live sensor.

    Bind the sensor once, `Digit = functools.partial(DigitCamera, sensor=live)`, and code that says
    `Digit("D12345", "left finger")` runs as it is.
    """

    STREAMS: ClassVar[dict[str, dict[str, Any]]] = {
        "VGA": {"resolution": {"width": 640, "height": 480}, "fps": {"30fps": 30, "15fps": 15}},
        "QVGA": {"resolution": {"width": 320, "height": 240}, "fps": {"60fps": 60, "30fps": 30}},
    }
    """The streams: width and height of the landscape picture [px], frame rates [1/s]."""
    dev_name: ClassVar[str] = "simulated"
    """Device file of a real one."""
    manufacturer: ClassVar[str] = "magicsim"
    model: ClassVar[str] = "simulated DIGIT"
    revision: ClassVar[str] = "1"
    LIGHTING_MIN: ClassVar[int] = 0
    LIGHTING_MAX: ClassVar[int] = 15

    def __init__(self, serial: str = "SIM00001", name: str | None = None, *, sensor: LiveSensor) -> None:
        """Names the camera; `connect` opens it.

        Args:
            serial: Serial number, of any form.
            name: Name for people.
            sensor: Moved by its owner; `disconnect` leaves it open.
        """
        self.serial = serial
        self.name = name or serial
        self._sensor = sensor
        self._is_connected = False
        self._stream = "QVGA"
        self.intensity = (self.LIGHTING_MAX,) * 3
        """Strength of the red, green and blue LEDs, 0..15."""

    @property
    def resolution(self) -> dict[str, int]:
        """Width and height of the stream's landscape picture [px]."""
        return dict(self.STREAMS[self._stream]["resolution"])

    @property
    def fps(self) -> int:
        """Frame rate [1/s]."""
        return round(self._sensor.frames_per_second)

    def connect(self) -> None:
        """Opens the stream: QVGA at 60 frames a second, LEDs at full strength."""
        self._is_connected = True
        self.set_resolution(self.STREAMS["QVGA"])
        self.set_intensity(self.LIGHTING_MAX)

    def disconnect(self) -> None:
        """Closes the stream; may be called again."""
        self._is_connected = False

    def set_resolution(self, resolution: Mapping[str, Any]) -> None:
        """Chooses a stream, at its highest frame rate.

        Args:
            resolution: `STREAMS["QVGA"]` or `STREAMS["VGA"]`.

        Raises:
            ConfigError: Not connected, or another size.
        """
        self._check_connected()
        asked = resolution.get("resolution", resolution)
        chosen = next((name for name, stream in self.STREAMS.items() if stream["resolution"] == asked), None)
        if chosen is None:
            allowed = " or ".join(f"STREAMS['{name}']" for name in self.STREAMS)
            raise ConfigError(f"resolution = {dict(asked)} is not allowed: must be {allowed}")
        self._stream = chosen
        self._sensor.set_image_size(columns=asked["height"], rows=asked["width"])
        self.set_fps(max(self._rates))

    def set_fps(self, fps: int) -> None:
        """Chooses one of the stream's frame rates [1/s]; `ConfigError` for others."""
        self._check_connected()
        if fps not in self._rates:
            allowed = " or ".join(str(rate) for rate in self._rates)
            raise ConfigError(f"fps = {fps} is not allowed: must be {allowed} in the stream {self._stream}")
        self._sensor.set_frame_rate(fps)

    def set_intensity(self, intensity: int) -> int:
        """Sets all LEDs, 0..15, and returns the strength."""
        self.set_intensity_rgb(intensity, intensity, intensity)
        return intensity

    def set_intensity_rgb(self, intensity_r: int, intensity_g: int, intensity_b: int) -> tuple[int, int, int]:
        """Sets red, green and blue LEDs, each 0..15, and returns the strengths.

        Light is proportional to the number, and 15 is the rig's own radiance. Exposure stays as it was metered at 15.

        Raises:
            ConfigError: Not connected, or a strength is not a whole number from 0 to 15.
        """
        self._check_connected()
        strengths = (intensity_r, intensity_g, intensity_b)
        for colour, value in zip("rgb", strengths, strict=True):
            check_number(f"intensity_{colour}", value, self.LIGHTING_MIN, self.LIGHTING_MAX, whole=True)
        self.intensity = strengths
        red, green, blue = (value / self.LIGHTING_MAX for value in strengths)
        self._sensor.set_led_strength(red, green, blue)
        return strengths

    def get_frame(self, transpose: bool = False) -> Frame:
        """The next frame.

        Args:
            transpose: Whether to give the landscape picture of the image sensor.

        Returns:
            BGR image, shape (320, 240, 3) in QVGA; (240, 320, 3) when transposed.

        Raises:
            ConfigError: Not connected.
            RenderError: The image is not valid.
        """
        self._check_connected()
        frame = as_bgr(self._sensor.frame().image)
        return as_landscape(frame) if transpose else frame

    def get_diff(self, ref_frame: Frame) -> Frame:
        """The next frame's absolute difference from a reference frame, BGR uint8; nothing wraps around.

        Args:
            ref_frame: From `get_frame`.

        Raises:
            ConfigError: Not connected.
            FrameError: The reference has another shape or type.
        """
        frame = self.get_frame()
        if ref_frame.shape != frame.shape or ref_frame.dtype != frame.dtype:
            raise FrameError(f"ref_frame is {ref_frame.dtype} {ref_frame.shape}, must be {frame.dtype} {frame.shape}")
        return np.asarray(cv2.absdiff(frame, ref_frame), np.uint8)

    def show_view(self, ref_frame: Frame | None = None, *, frames: int | None = None) -> None:
        """Shows frame after frame until Escape is pressed in the window, or the window is closed.

        Without a screen they are shown in a page on 127.0.0.1, whose address is written to stderr, until Ctrl-C.

        Args:
            ref_frame: Shows the difference from it instead, as `get_diff`.
            frames: Ends after so many; a DIGIT's own method has no such limit.

        Raises:
            ConfigError: Not connected.
            FrameError: The reference has another shape or type.
        """
        self._check_connected()
        picture = Picture(f"Digit View {self.serial}")
        try:
            while picture.is_open and (frames is None or frames > 0):
                shown = self.get_frame() if ref_frame is None else self.get_diff(ref_frame)
                picture.show(np.ascontiguousarray(shown[..., ::-1]))
                frames = frames - 1 if frames is not None else None
        except KeyboardInterrupt:
            return
        finally:
            picture.close()

    def save_frame(self, path: str | Path) -> Frame:
        """Takes the next frame, writes it as an image of the path's suffix, and returns it.

        Raises:
            ConfigError: Not connected, or an unknown suffix.
            OutputError: The file cannot be written.
        """
        target = Path(path)
        if not cv2.haveImageWriter(target.name):
            msg = f"path = '{target}' is not allowed: must end in .png, .jpg or another image suffix of OpenCV"
            raise ConfigError(msg)
        frame = self.get_frame()
        with result_file(target) as partial:
            partial.write_bytes(cv2.imencode(target.suffix, frame)[1].tobytes())
        return frame

    def info(self) -> str:
        """A few lines about the camera."""
        return (
            f"Name: {self.name}\nSerial: {self.serial}\nSimulated: magicsim\nConnected: {self._is_connected}\n"
            f"Resolution: {self.resolution['width']} x {self.resolution['height']}\nFPS: {self.fps}\n"
            f"LED intensity: {self.intensity}"
        )

    @property
    def _rates(self) -> list[int]:
        return list(self.STREAMS[self._stream]["fps"].values())

    def _check_connected(self) -> None:
        if not self._is_connected:
            raise ConfigError(f"DIGIT {self.serial} is not connected: call connect() first")
