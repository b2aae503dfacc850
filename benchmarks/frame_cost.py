"""What a frame of an episode costs, and whether memory stays flat: the light and camera of many moving frames.

    python benchmarks/frame_cost.py                        # the demo's frames at its own settings
    python benchmarks/frame_cost.py --repeat 60 --set rig.camera.columns=60 --set rig.camera.rows=80   # 2,000 and more

Prints one JSON object: for every kind of state the number of frames and the median seconds of light and camera with the
update of the meshes (no solving), and the resident memory after each repetition of the episode. `warping_seconds` is
what new vertices cost of a touching frame, and `still_cells` the share of cells that hardly moved since the one before.
"""

import argparse
import json
import resource
import statistics
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.deform.deformation import Deformation
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor

STILL_MM = 1e-4
"""A cell none of whose vertices moved by more stands still [mm]."""


def kind_of(state: FrameState, deformation: Deformation) -> str:
    """`flashlight`, `touching`, `near` or `untouched`."""
    if state.flashlight:
        return "flashlight"
    if not deformation.is_rest:
        return "touching"
    return "near" if state.has_object else "untouched"


def resident_mib() -> float:
    """Memory of this process now [MiB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def warping(sensor: Sensor, touching: list[tuple[FrameState, Deformation]]) -> dict[str, float | None]:
    """Median seconds of new vertices and their checks, and median share of cells that stand still; None without any.

    Args:
        sensor: In its scene.
        touching: States in which the block is deformed, in order.
    """
    seconds, still, before = [], [], None
    cells = int(np.prod(sensor.elastomer.grid.counts)) if sensor.elastomer.grid is not None else 0
    for state, deformation in touching:
        start = time.perf_counter()
        now = sensor.view(state, deformation).infill
        seconds.append(time.perf_counter() - start)
        if now is not None and before is not None:
            still.append(float((np.abs(now - before).reshape(cells, -1).max(1) < STILL_MM).mean()))
        before = now
    return {
        "warping_seconds": round(statistics.median(seconds), 4) if seconds else None,
        "still_cells": statistics.median(still) if still else None,
    }


def measure(scene: str, settings: list[str], repeat: int) -> dict[str, object]:
    """Renders the episode's states again and again.

    Args:
        scene: A preset's name or a file.
        settings: Overrides.
        repeat: How many times.
    """
    loaded = load_scene(scene, settings)
    sensor, plan = Sensor.for_scene(loaded), plan_scene(loaded)
    sensor.warm_up([frame.state for frame in plan.frames if frame.same_as is None])
    sensor.renderer.metered()
    states, deformation = [], sensor.rest
    for frame in plan.frames:
        if frame.same_as is None:
            deformation = sensor.deform(frame.state, deformation) if frame.solve else sensor.rest
            states.append((frame.state, deformation))
            sensor.renderer.prepare(sensor.view(frame.state, deformation))
    seconds: dict[str, list[float]] = {}
    memory = []
    checksum: npt.NDArray[np.float64] = np.zeros(3)
    for _ in range(repeat):
        for state, deformation in states:
            start = time.perf_counter()
            image = sensor.radiance(state, deformation)
            seconds.setdefault(kind_of(state, deformation), []).append(time.perf_counter() - start)
            checksum += image.mean((0, 1))
        memory.append(round(resident_mib(), 1))
    lit = [value for kind, values in seconds.items() if kind != "untouched" for value in values]
    return {
        "frames": repeat * len(states),
        "seconds": {kind: round(statistics.median(values), 4) for kind, values in seconds.items()},
        "states": {kind: len(values) // repeat for kind, values in seconds.items()},
        "median_seconds": round(statistics.median(lit), 4),
        **warping(sensor, [each for each in states if not each[1].is_rest]),
        "memory_mib": memory,
        "mean_radiance": (checksum / (repeat * len(states))).tolist(),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="demo")
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    given = parser.parse_args()
    print(json.dumps(measure(given.scene, given.settings, given.repeat)))
