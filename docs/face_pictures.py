"""Draws `docs/faces.jpg`: every sensor of `docs/faces.md`, untouched and under a ball.

python docs/face_pictures.py
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from magicsim.camera.stream import Instant
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor, sensor_camera

NAMES = (
    "mini-magictac-finger", "gelsight-type", "gelsight-type-markers", "marker-type", "see-through-markers",
    "translucent-9dtact",
)  # fmt: skip
PRESSED_FRAME = 8
HEIGHT_PX, WIDTH_PX = 200, 240


def pair(name: str) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """An untouched and a pressed frame below each other."""
    sensor = Sensor(load_scene(name))
    untouched = sensor.radiance(UNTOUCHED, sensor.rest)
    camera = sensor_camera(sensor, untouched)
    state = timeline(sensor.scene)[PRESSED_FRAME]
    pressed = sensor.radiance(state, sensor.deform(state, sensor.rest))
    rate = sensor.scene.frames_per_second
    shots = []
    for index, radiance in enumerate((untouched, pressed)):
        at = Instant(seed=1, index=index, time_s=index / rate, frames_per_second=rate)
        image = camera.take(radiance, camera.begin(rate), at)[0]
        scale = min(HEIGHT_PX / image.shape[0], WIDTH_PX / image.shape[1])
        small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        frame = np.full((HEIGHT_PX, WIDTH_PX, 3), 255, np.uint8)
        top, left = (HEIGHT_PX - small.shape[0]) // 2, (WIDTH_PX - small.shape[1]) // 2
        frame[top : top + small.shape[0], left : left + small.shape[1]] = small
        shots.append(frame)
    return np.concatenate(shots)


def main(folder: Path) -> None:
    """Writes the picture."""
    activate_variant()
    pairs = []
    for name in NAMES:
        pairs.append(pair(name))
        cv2.imwrite(str(folder / "faces.jpg"), cv2.cvtColor(np.concatenate(pairs, 1), cv2.COLOR_RGB2BGR))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
