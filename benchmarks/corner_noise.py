"""Noise of a frame far from the contact, against the gap: it must not tell whether the object touches.

    python benchmarks/corner_noise.py [--seed 2] [--still 0.001] [--gaps 0.02 0.004 -0.01 -0.02 -0.05 -0.2 -1]

A ball of 4 mm at the middle of the default sensor, camera noise off. For each gap: standard deviation, in the four
corners of 60 x 50 pixels, of what a pixel's change from rest differs by from the mean of its four neighbours, and the
mean change of the whole image, by channel [grey levels]; seconds of light and camera pass.
"""

import argparse
import json
import time

import numpy as np
import numpy.typing as npt

from magicsim.camera.exposure import meter
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
ROWS, COLUMNS = 60, 50
CORNERS = [(r, c) for r in (slice(ROWS), slice(-ROWS, None)) for c in (slice(COLUMNS), slice(-COLUMNS, None))]


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--still", type=float, default=0.001)
    parser.add_argument("--gaps", type=float, nargs="+", default=[0.02, 0.004, -0.01, -0.02, -0.05, -0.2, -1.0])
    chosen = parser.parse_args()
    press = f"keyframes=[{{frame=0,gap_mm={min(*chosen.gaps, -0.01)}}}]"
    settings = ["references=1", "object.radius_mm=4", f"render.still_mm={chosen.still}", press]
    sensor = Sensor.for_scene(load_scene("pressed", settings, seed=chosen.seed))
    camera = sensor.rig.camera
    untouched = sensor.radiance(UNTOUCHED, sensor.rest)
    gain = meter(untouched, camera).gain

    def grey(radiance: npt.NDArray[np.float32]) -> Array:
        return np.asarray(255 * (np.maximum(radiance, 0) * gain) ** (1 / camera.gamma), np.float64)

    rest = grey(untouched)
    for gap_mm in chosen.gaps:
        state = FrameState(gap_mm=gap_mm, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
        deformation = sensor.deform(state, sensor.rest) if can_touch(state) else sensor.rest
        start = time.perf_counter()
        change = grey(sensor.radiance(state, deformation)) - rest
        seconds = time.perf_counter() - start
        around = sum(np.roll(change, step, axis) for step in (-1, 1) for axis in (0, 1)) / 4
        noise = np.mean([(change - around)[corner].std((0, 1)) for corner in CORNERS], axis=0)
        row = {"gap_mm": gap_mm, "noise": noise.round(3).tolist(), "change": change.mean((0, 1)).round(3).tolist()}
        print(json.dumps(row | {"seconds": round(seconds, 2)}), flush=True)


if __name__ == "__main__":
    main()
