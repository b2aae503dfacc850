"""One rendering, any lights: the sensor with its red strip at half strength and its blue one off.

python docs/examples/dim_a_light.py        # mean radiance before and after, some seconds
"""

import numpy as np

from magicsim import load_scene
from magicsim.light.relight import relight
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor


def images(settings: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """The untouched sensor with all lights as they are, and with changed ones, each (rows, columns, 3)."""
    sensor = Sensor.for_scene(load_scene("rest", settings))
    view = sensor.view(UNTOUCHED, sensor.rest)
    basis = sensor.renderer.basis(view)
    return relight(basis, {}), relight(basis, {"strip0": 0.5, "strip1": 0.0})


if __name__ == "__main__":
    for image in images([]):
        print(image.mean((0, 1)))
