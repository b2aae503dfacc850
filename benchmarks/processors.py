"""Frames by one kind of processor beside those by another: how far apart, and how long each takes.

    python benchmarks/processors.py save FILE                                       # by LLVM
    MAGICSIM_VARIANT=cuda_ad_rgb python benchmarks/processors.py compare FILE       # on an NVIDIA GPU, with that file

The file holds states of the demo with their deformations, solved once, and their radiance (a pickle: read none that
you did not write). `compare` prints one JSON object: for every state the difference of each channel's mean over that
mean, and the root mean square difference over the mean; for every kind of state the median seconds of a frame's light
and image, without solving; the seconds of the sensor's first frame with nothing kept; and the same seconds in the file.
"""

import argparse
import json
import os
import pickle
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

os.environ.setdefault("MAGICSIM_CACHE", "off")

from frame_cost import kind_of

from magicsim.light.backend import VARIANT
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor

Image = npt.NDArray[np.float32]
OF_EACH = 4
"""States of each kind, spread over the episode."""
WARM = 2
"""Rounds before those that are timed: the first compile."""


def chosen_states(sensor: Sensor, scene: SceneConfig) -> list[tuple[str, Any, Any]]:
    """Kind, state and deformation of some states of each kind."""
    found: dict[str, list[tuple[str, Any, Any]]] = {}
    deformation = sensor.rest
    for frame in plan_scene(scene).frames:
        if frame.same_as is None:
            deformation = sensor.deform(frame.state, deformation) if frame.solve else sensor.rest
            kind = kind_of(frame.state, deformation)
            found.setdefault(kind, []).append((kind, frame.state, deformation))
    places = {kind: np.unique(np.linspace(0, len(of) - 1, OF_EACH).round().astype(int)) for kind, of in found.items()}
    return [found[kind][place] for kind in found for place in places[kind]]


def measure(sensor: Sensor, states: list[tuple[str, Any, Any]], repeat: int) -> tuple[list[Image], dict[str, float]]:
    """Radiance of each state, and seconds: of the `first` frame, and the median of each kind."""
    start = time.perf_counter()
    sensor.radiance(*states[0][1:])
    first, seconds = time.perf_counter() - start, {}
    images: list[Image] = []
    for turn in range(WARM + repeat):
        for kind, state, deformation in states:
            start = time.perf_counter()
            image = sensor.radiance(state, deformation)
            if turn == 0:
                images.append(image)
            elif turn >= WARM:
                seconds.setdefault(kind, []).append(time.perf_counter() - start)
    return images, {"first": first} | {kind: statistics.median(each) for kind, each in seconds.items()}


def difference(one: Image, other: Image) -> dict[str, Any]:
    """How far an image is from another one, see above."""
    mean = np.mean(other, (0, 1), np.float64)
    apart = (np.mean(one, (0, 1), np.float64) / mean - 1).tolist()
    rms = float(np.sqrt(np.mean(np.square(one - other), dtype=np.float64)) / mean.mean())
    return {"means": [round(each, 5) for each in apart], "rms": round(rms, 5)}


def main(task: str, file: Path, settings: list[str], repeat: int) -> dict[str, Any]:
    """Saves, or compares with what was saved."""
    scene = load_scene("demo", settings)
    sensor = Sensor.for_scene(scene)
    kept = pickle.loads(file.read_bytes()) if task == "compare" else None
    states = kept["states"] if kept else chosen_states(sensor, scene)
    images, seconds = measure(sensor, states, repeat)
    about = {"variant": VARIANT, "seconds": {kind: round(each, 4) for kind, each in seconds.items()}}
    if kept is None:
        file.write_bytes(pickle.dumps({"states": states, "images": images, "about": about}))
        return about
    kinds = [kind for kind, *_ in states]
    apart = [{"kind": k, **difference(a, b)} for k, a, b in zip(kinds, images, kept["images"], strict=True)]
    return {**about, "saved": kept["about"], "states": apart}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=("save", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    given = parser.parse_args()
    print(json.dumps(main(given.task, given.file, given.settings, given.repeat), indent=1))
