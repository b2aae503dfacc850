"""A judge with closed-form objectives and a known front: importable by name, so that other processes can call it."""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

from magicsim.errors import GeometryError
from magicsim.sweep.comparison import DesignTask, run_sweep
from magicsim.sweep.measures import Measured
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.workers.attempt import Work, WorkerOptions

from .fakes import no_variant, result_of, small_sweep

FIELDS = {
    "design.cell_mm": (0.6, 0.8), "design.skin_mm": (0.5, 1.5), "rig.camera.gamma": (1.0, 2.2),
    "rig.camera.exposure_grey": (60.0, 120.0),
}  # fmt: skip


def searching(count: int, *more: str, sampling: str = "search", batch: int = 4) -> SweepConfig:
    swept = ",".join(f"{{field='{name}',low={low},high={high}}}" for name, (low, high) in FIELDS.items())
    search = [f"search.batch={batch}", "search.start=8"] if sampling == "search" else []
    return small_sweep(
        f"swept=[{swept}]", f"sampling='{sampling}'", f"count={count}", *search,
        "measures=['localisation_mm','unknowns','printability']",
        "objectives=[{measure='localisation_mm'},{measure='unknowns'}]", *more,
    )  # fmt: skip


def shares(values: dict[str, float]) -> list[float]:
    """Place of each field in its range, 0..1."""
    return [(values[name] - low) / (high - low) for name, (low, high) in FIELDS.items()]


def quadratic(task: DesignTask) -> bytes:
    """Two squared distances whose front is the line between their centres: sqrt(f1) + sqrt(f2) = 0.5 there alone."""
    time.sleep(float(os.environ.get("FAKE_SECONDS", "0")))
    x, *others = shares(task.design.values)
    aside = sum((each - 0.35) ** 2 for each in others)
    told = {"localisation_mm": (x - 0.2) ** 2 + aside, "unknowns": (x - 0.7) ** 2 + aside, "printability": x}
    measures = {name: Measured(value=value, low=value, high=value) for name, value in told.items()}
    return replace(result_of(task), measures=measures).to_json()


def partly(task: DesignTask) -> bytes:
    """As `quadratic`, but what has x above 0.5 cannot be built."""
    if shares(task.design.values)[0] > 0.5:
        msg = "no cell fits along z"
        raise GeometryError(msg)
    return quadratic(task)


QUADRATIC = Work(function=quadratic, prepare=None, variant=no_variant)
PARTLY = Work(function=partly, prepare=None, variant=no_variant)

if __name__ == "__main__":
    run_sweep(searching(16), Path(sys.argv[1]), options=WorkerOptions(workers=1), resume=True, judge=QUADRATIC)
