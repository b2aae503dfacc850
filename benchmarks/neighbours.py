"""How much a frame moves between neighbouring places of an object by chance: what a sequence of frames shows as noise.

    python benchmarks/neighbours.py [--out neighbours.json]

Each row is a short approach or press in even steps, rendered without the camera's noise and judged by `calibrated`.
The noise is the second difference over sqrt(6), which a smooth change hardly adds to: of the similarity S, and of means
over blocks of 20 x 20 pixels in units of the mean radiance.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from magicsim.camera.exposure import expose
from magicsim.detectors import detect, fuse, load_profile
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor, sensor_exposure

BLOCK_PX = 20
QUIET = ("rig.camera.full_well_e=1e9", "rig.camera.read_noise_e=0", "rig.camera.fixed_pattern=0")
OBJECTS = {"ball": (), "large ball": ("object.radius_mm=12",)}
WAYS = {
    "near, 1 mm": np.arange(1.0, 0.6, -0.04),
    "near, 0.2 mm": np.arange(0.2, 0.0, -0.02),
    "touched, 0.02 to 0.18 mm": np.arange(-0.02, -0.2, -0.02),
    "touched, 0.5 to 0.6 mm": np.arange(-0.5, -0.605, -0.0125),
}


def by_chance(values: np.ndarray) -> float:
    """Noise of values along the first axis [in their unit]."""
    return float(((values[2:] - 2 * values[1:-1] + values[:-2]) / np.sqrt(6)).std())


def rows(overrides: tuple[str, ...]) -> dict[str, dict[str, float]]:
    """Noise of S and of blocks along each way of one object."""
    press = "keyframes=[{frame=0,gap_mm=-0.6,x_mm=1.0,y_mm=0.5}]"
    sensor = Sensor.for_scene(load_scene("near", [press, *QUIET, *overrides], seed=1))
    rest, camera, profile = sensor.radiance(UNTOUCHED, sensor.rest), sensor.rig.camera, load_profile("calibrated")
    exposure = sensor_exposure(sensor, rest)
    references = fuse([expose(rest, exposure, camera, seed=0, frame=0)] * profile.reference_count, profile)
    found = {}
    for name, gaps in WAYS.items():
        deformation, images, similarities = sensor.rest, [], []
        for gap in gaps:
            state = FrameState(gap_mm=float(gap), x_mm=1.0, y_mm=0.5, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
            deformation = sensor.deform(state, deformation) if gap < 0 else sensor.rest
            image = sensor.radiance(state, deformation)
            images.append(image.astype(float))
            similarities.append(
                detect(expose(image, exposure, camera, seed=0, frame=0), references, profile).similarity
            )
        rows_px, columns_px = (size // BLOCK_PX for size in images[0].shape[:2])
        cut = np.array(images)[:, : rows_px * BLOCK_PX, : columns_px * BLOCK_PX]
        blocks = cut.reshape(len(cut), rows_px, BLOCK_PX, columns_px, BLOCK_PX, 3).mean((2, 4))
        found[name] = {
            "similarity": float(np.mean(similarities)),
            "similarity_noise": by_chance(np.array(similarities)),
            "block_noise": by_chance(blocks) / float(rest.mean()),
        }
    return found


def main() -> None:
    """Prints the table and keeps it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("neighbours.json"))
    arguments = parser.parse_args()
    found = {name: rows(overrides) for name, overrides in OBJECTS.items()}
    for name, ways in found.items():
        for way, each in ways.items():
            print(f"{name:11s} {way:26s} S {each['similarity']:.4f} +- {each['similarity_noise']:.5f}"
                  f"   blocks {100 * each['block_noise']:.3f} %")  # fmt: skip
    arguments.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
