"""What a touched frame costs and errs, against how deep it is.

    python benchmarks/depth_cost.py --out docs/benchmarks [--set render.reuse_mm=0]

A ball stands 1 mm before the default design, and is pressed 0.005 to 2 mm deep. A frame is rendered as in an episode,
with several seeds of its own and of its anchor. Seconds of light and camera are the least of three, meshes moved and
search tree built, the untouched sensor and the light before contact known; those of the solve, from rest, stand beside
them. Error is the root mean square deviation from the mean of independent images without an anchor, less their own
noise, over the image's mean. Writes depth-cost.json and depth-cost.png.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np

from magicsim.bench.light.render_statistics import deviation
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

GAPS_MM = (1.0, -0.005, -0.05, -0.1, -0.3, -1.0, -2.0)
SEEDS = (1, 2, 3, 4)
CONVERGED = ("render.samples=16", "render.particles=300000", "render.anchor_samples=0")


@dataclass(frozen=True, slots=True, kw_only=True)
class DepthRow:
    """One gap."""

    gap_mm: float
    solve_seconds: float
    seconds: float
    error: float
    error_of_error: float


def sensor_at(gap_mm: float, settings: list[str], seed: int) -> Sensor:
    """A sensor with the ball at a gap."""
    keyframe = f"keyframes=[{{frame=0,gap_mm={gap_mm}}}]"
    return Sensor.for_scene(load_scene("pressed", [*settings, keyframe], seed=seed))


def measure(gap_mm: float, settings: list[str]) -> DepthRow:
    """Cost and error at a gap."""
    frames, seconds, solve = [], [], 0.0
    for seed in SEEDS:
        sensor = sensor_at(gap_mm, [*settings, f"render.anchor_seed={seed}"], seed)
        state = sensor.states[0]
        if seed == SEEDS[0]:
            start = time.perf_counter()
            deformation = sensor.deform(state, sensor.rest) if can_touch(state) else sensor.rest
            solve = time.perf_counter() - start
        frame, took = sensor.radiance(state, deformation), []
        for _ in range(3):
            start = time.perf_counter()
            frame = sensor.radiance(state, deformation)
            took.append(time.perf_counter() - start)
        frames.append(frame.astype(np.float64))
        seconds.append(min(took))
    independent = sensor_at(gap_mm, list(CONVERGED), 0)
    view = independent.view(state, deformation)
    truth = [independent.renderer.plain_radiance(view, turn=1 + k).astype(np.float64) for k in range(len(SEEDS))]
    error = deviation(frames, truth)
    return DepthRow(
        gap_mm=gap_mm, solve_seconds=solve, seconds=float(np.median(seconds)),
        error=error.value, error_of_error=error.error,
    )  # fmt: skip


def plot(rows: list[DepthRow], path: Path) -> None:
    """Seconds and error against depth; the frame before contact as a line."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    near, touched = rows[0], rows[1:]
    depth = [-row.gap_mm for row in touched]
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    shown = (
        ("seconds of light and camera", near.seconds, [row.seconds for row in touched]),
        ("relative error", near.error, [row.error for row in touched]),
    )
    for axis, (label, before, values) in zip(axes, shown, strict=True):
        axis.semilogx(depth, values, "o-", label="pressed")
        axis.axhline(before, color="0.5", ls="--", label="1 mm before contact")
        axis.set(xlabel="depth [mm]", ylabel=label, ylim=(0, None))
        axis.legend()
    figure.savefig(path, dpi=110)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    chosen = parser.parse_args()
    rows = []
    for gap_mm in GAPS_MM:
        rows.append(measure(gap_mm, chosen.settings))
        print(json.dumps(asdict(rows[-1])), flush=True)
    found = {"settings": chosen.settings, "results": [asdict(row) for row in rows]}
    (chosen.out / "depth-cost.json").write_text(json.dumps(found, indent=1) + "\n")
    plot(rows, chosen.out / "depth-cost.png")


if __name__ == "__main__":
    main()
