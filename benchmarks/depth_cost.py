"""What a touched frame costs and errs, against how deep it is.

    python benchmarks/depth_cost.py --out docs/benchmarks [--set render.reuse_mm=0] [--gaps -1 -2]

A ball stands 1 mm before the default design, and is pressed 0.005 to 2 mm deep; 1 mm deep also with fewer samples and
particles. A frame is rendered as in an episode, with several seeds of its own and of its anchor. Seconds of light and
camera are the least of three, meshes moved and search tree built, the untouched sensor and the light before contact
known. What frames of a sensor share of these is timed with nothing kept, in the seeds after the first, which compiles:
all of it in `shared_seconds`, and a frame's part of it, in an episode of 100, in `seconds_with_share`. Seconds of the
solve, from rest, stand beside them. Error is the root mean square deviation from the mean of independent images without
an anchor, less their own noise, over the image's mean. Writes depth-cost.json and depth-cost.png; `--gaps` measures
some gaps and keeps the others as they stand there.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from laboratory.light.render import EPISODE_FRAMES
from laboratory.light.render_statistics import deviation

from magicsim.light.records.untouched_store import UntouchedStates
from magicsim.scenes.scene import RenderSettings, load_scene
from magicsim.simulation.sensor import Sensor

GAPS_MM = (1.0, -0.005, -0.05, -0.1, -0.3, -1.0, -2.0)
DEFAULT = (RenderSettings().samples, RenderSettings().particles)
COARSER = ((2, 12_000), (1, 6_000))
"""Camera samples of a pixel and light particles: errors near 5 and 7 %."""
COARSER_AT_MM = -1.0
SEEDS = (1, 2, 3, 4)
CONVERGED = ("render.samples=16", "render.particles=300000", "render.anchor_samples=0")


@dataclass(frozen=True, slots=True, kw_only=True)
class DepthRow:
    """One gap at one quality."""

    gap_mm: float
    samples: int
    particles: int
    solve_seconds: float
    seconds: float
    shared_seconds: float
    seconds_with_share: float
    error: float
    error_of_error: float


def sensor_at(gap_mm: float, settings: list[str], seed: int) -> Sensor:
    """A sensor with the ball at a gap."""
    keyframe = f"keyframes=[{{frame=0,gap_mm={gap_mm}}}]"
    # Nothing is kept on disk: what frames share is timed.
    return Sensor.for_scene(load_scene("pressed", [*settings, keyframe], seed=seed), untouched=UntouchedStates())


def measure(gap_mm: float, quality: tuple[int, int], settings: list[str]) -> DepthRow:
    """Cost and error at a gap with so many samples and particles."""
    frames, seconds, shared, solve = [], [], [], 0.0
    asked = [f"render.samples={quality[0]}", f"render.particles={quality[1]}"]
    for seed in SEEDS:
        sensor = sensor_at(gap_mm, [*settings, *asked, f"render.anchor_seed={seed}"], seed)
        state = sensor.states[0]
        if seed == SEEDS[0]:
            start = time.perf_counter()
            deformation = sensor.deform(state, sensor.rest) if state.can_touch else sensor.rest
            solve = time.perf_counter() - start
        start = time.perf_counter()
        frame, took = sensor.radiance(state, deformation), []
        first = time.perf_counter() - start
        for _ in range(3):
            start = time.perf_counter()
            frame = sensor.radiance(state, deformation)
            took.append(time.perf_counter() - start)
        frames.append(frame.astype(np.float64))
        seconds.append(min(took))
        shared.append(max(0.0, first - min(took)))
    independent = sensor_at(gap_mm, [*settings, *CONVERGED], 0)
    view = independent.view(state, deformation)
    truth = [independent.renderer.plain_radiance(view, turn=1 + k).astype(np.float64) for k in range(len(SEEDS))]
    error, own, common = deviation(frames, truth), float(np.median(seconds)), float(np.median(shared[1:]))
    return DepthRow(
        gap_mm=gap_mm, samples=quality[0], particles=quality[1], solve_seconds=solve, seconds=own,
        shared_seconds=common, seconds_with_share=own + common / EPISODE_FRAMES, error=error.value,
        error_of_error=error.error,
    )  # fmt: skip


def plot(rows: list[DepthRow], path: Path) -> None:
    """Seconds and error against depth; the frame before contact as a line."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    near, *touched = [row for row in rows if (row.samples, row.particles) == DEFAULT]
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
    parser.add_argument("--gaps", type=float, nargs="+", default=GAPS_MM, choices=GAPS_MM, help="of these [mm]")
    chosen = parser.parse_args()
    path, whole = chosen.out / "depth-cost.json", cases()
    known = {} if set(chosen.gaps) == set(GAPS_MM) else _kept(path, chosen.settings)
    for gap_mm, quality in whole:
        if gap_mm in chosen.gaps:
            known[gap_mm, quality] = measure(gap_mm, quality, chosen.settings)
            print(json.dumps(asdict(known[gap_mm, quality])), flush=True)
    rows = [known[case] for case in whole if case in known]
    found = {"settings": chosen.settings, "episode_frames": EPISODE_FRAMES, "results": [asdict(row) for row in rows]}
    path.write_text(json.dumps(found, indent=1) + "\n")
    if len(rows) == len(whole):
        plot(rows, chosen.out / "depth-cost.png")


def cases() -> list[tuple[float, tuple[int, int]]]:
    """Gap [mm] and quality of each row: every gap at the default one, `COARSER_AT_MM` coarser too."""
    return [*((gap_mm, DEFAULT) for gap_mm in GAPS_MM), *((COARSER_AT_MM, quality) for quality in COARSER)]


def _kept(path: Path, settings: list[str]) -> dict[tuple[float, tuple[int, int]], DepthRow]:
    """Rows of an earlier run with the same settings, by gap and quality."""
    known = json.loads(path.read_text()) if path.exists() else {}
    if known.get("settings") != settings or "episode_frames" not in known:
        return {}
    rows = [DepthRow(**row) for row in known["results"]]
    return {(row.gap_mm, (row.samples, row.particles)): row for row in rows}


if __name__ == "__main__":
    main()
