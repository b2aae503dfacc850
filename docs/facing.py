"""Pictures of one sensor alone and with another one before it: `python docs/facing.py` writes `docs/facing.jpg`."""

from pathlib import Path

import cv2
import numpy as np

from magicsim.robot.live import live_sensor
from magicsim.robot.workspace import Workspace

DISTANCES_MM = (None, 60.0, 30.0, 12.0, 6.0)
HERE = Path(__file__).parent


def main() -> None:
    """Renders and writes."""
    images = []
    with live_sensor(
        "grip", workspace=Workspace(x_mm=(0, 0), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(-1, 30))
    ) as sensor:
        for distance in DISTANCES_MM:
            sensor.face(distance)
            images.append(np.pad(sensor.frame().image, ((0, 0), (0, 6), (0, 0)), constant_values=255))
    sheet = np.hstack(images)[:, :-6, ::-1]
    cv2.imwrite(str(HERE / "facing.jpg"), np.ascontiguousarray(sheet), [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
