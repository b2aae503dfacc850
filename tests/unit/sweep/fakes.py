"""Judges that cost nothing: importable by name, so that other processes can call them."""

import json
import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path

from magicsim.errors import GeometryError
from magicsim.sweep.comparison import DesignTask, run_sweep
from magicsim.sweep.measures import MEASURES, Measured
from magicsim.sweep.parts import block_of
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import SweepConfig, load_sweep
from magicsim.workers.attempt import Work, WorkerOptions

FOLDER = Path(__file__).parent
NOTE = 'printed cell 0.6 to 1 mm, here 1.2; "recommended" core & <skin>'
PICTURE = "data:image/webp;base64,UklGRiQAAABXRUJQVlA4IBgAAAAwAQCdASoBAAEAAgA0JaQAA3AA/vuUAAA="


def small_sweep(*more: str) -> SweepConfig:
    return load_sweep(FOLDER / "small.toml", more)


def result_of(task: DesignTask) -> DesignResult:
    """Values that follow the published trends, with an interval."""
    values = task.design.values
    cell, skin = values["design.cell_mm"], values["design.skin_mm"]
    told = {
        "shore_a": 25 + 4 * skin, "force_1mm_n": 3 + skin, "sensitivity_per_n": 0.9 - 0.5 * skin + 0.05 * cell,
        "localisation_mm": 0.2 + 0.5 * cell,
    }  # fmt: skip
    measures = {
        name: Measured(value=told.get(name, 1.0), low=told.get(name, 1.0) - 0.1, high=told.get(name, 1.0) + 0.1)
        for name in MEASURES
    }
    measures["printability"] = replace(measures["printability"], note=NOTE)
    depths, gaps = [0.0, 0.5, 1.0], [20.0, 5.0, 1.0]
    return DesignResult(
        index=task.design.index,
        values=values,
        is_extra=task.design.is_extra,
        block=block_of(task.design.sensor.design),
        measures=measures,
        curves={
            "force": {"depth_mm": depths, "force_n": [each * skin for each in depths]},
            "similarity": {"depth_mm": depths, "similarity": [1.0, 0.9, 0.8]},
            "approach": {"gap_mm": gaps, "entropy": [0.3, 1.0, 2.0], "correlation": [0, 0.3, 0.4], "rate": [0, 0.5, 1]},
            "lines_d_prime": {"spacing_mm": [1.6, 1.0], "d_prime": [1.6, 1.0]},
            "localisation": {"x_mm": [1.0], "y_mm": [2.0], "predicted_x_mm": [1.1], "predicted_y_mm": [2.1]},
        },
        pictures={"untouched": PICTURE, "depth 1 mm": PICTURE},
    )


def fake(task: DesignTask) -> bytes:
    time.sleep(float(os.environ.get("FAKE_SECONDS", "0")))
    return result_of(task).to_json()


def failing(task: DesignTask) -> bytes:
    """Design 1 cannot be built; design 2 crashes as long as a file says so."""
    if task.design.index == 1:
        msg = "no cell fits along z"
        raise GeometryError(msg)
    if task.design.index == 2 and Path(os.environ["FAKE_CRASH"]).exists():
        os.kill(os.getpid(), signal.SIGKILL)
    return fake(task)


def no_variant() -> str:
    return "none"


FAKE = Work(function=fake, prepare=None, variant=no_variant)
FAILING = Work(function=failing, prepare=None, variant=no_variant)

if __name__ == "__main__":
    summary = run_sweep(small_sweep(), Path(sys.argv[1]), options=WorkerOptions(workers=1), resume=True, judge=FAKE)
    sys.stdout.write(json.dumps({"designs": summary.designs}))
