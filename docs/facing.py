"""Pictures of one sensor alone and with another one before it: `python docs/facing.py` writes `docs/facing.jpg`.

Below each is its change against the sensor alone.
"""

from pathlib import Path

import cv2
import numpy as np

from magicsim.notebook.screen import change, on_screen
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
        gamma = sensor.scene.rig.camera.gamma
        for distance in DISTANCES_MM:
            sensor.face(distance)
            images.append(sensor.frame().image)
    pairs = [np.vstack([on_screen(each, gamma=gamma), change(each, images[0])]) for each in images]
    sheet = np.hstack([np.pad(each, ((0, 0), (0, 6), (0, 0)), constant_values=255) for each in pairs])[:, :-6, ::-1]
    cv2.imwrite(str(HERE / "facing.jpg"), np.ascontiguousarray(sheet), [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
