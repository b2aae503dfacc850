"""How fast a control loop runs at each quality, and how far `control` is from `full` along three controller runs.

    python benchmarks/control_loop.py --out docs/benchmarks/control-loop.json

Each run is a list of poses as a controller gave them, a step each: a press that is held, a press that is sheared and
released, and a grip that is twisted. Both qualities follow them in the same process, one after the other. A run is the
second of its kind for its sensor, so that nothing is compiled in it. `solve_s` and `light_s` are seconds of a clock on
the wall, which other work beside stretches; `cpu_s` is what all threads of this process worked, which it hardly does.
"""

import argparse
import json
import statistics
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from magicsim.errors import MagicsimError
from magicsim.judge.verdicts import SensorDetector, fused_profiles
from magicsim.robot import LiveSensor, Workspace, live_sensor

Pose = tuple[float, float, float]
"""Gap [mm], x [mm], twist [degrees]."""
RUNS: dict[str, list[Pose]] = {
    "press and hold": [(0.3, 0, 0), (-0.2, 0, 0), (-0.5, 0, 0), (-0.7, 0, 0), (-0.72, 0, 0), (-0.72, 0, 0)],
    "press, shear, release": [(0.3, 0, 0), (-0.5, 0, 0), (-0.5, 0.2, 0), (-0.5, 0.4, 0), (-0.3, 0.4, 0), (0.5, 0.4, 0)],
    "grip and twist": [(0.3, 0, 0), (-0.6, 0, 0), (-0.6, 0, 5), (-0.6, 0, 10), (-0.7, 0.1, 10), (0.5, 0.1, 10)],
}
SPACE = Workspace(x_mm=(-1, 1), y_mm=(-1, 1), twist_deg=(-20, 20), gap_mm=(-1.2, 10))
REFERENCES = 30


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One step of a run."""

    solve_s: float
    light_s: float
    cpu_s: float
    force_n: tuple[float, float, float]
    iterations: int
    verdicts: dict[str, str]
    in_contact: bool


def untouched(live: LiveSensor) -> dict[str, SensorDetector | str]:
    """Detectors that have learned the sensor."""
    return fused_profiles([live.frame().image for _ in range(REFERENCES)])


def follow(
    live: LiveSensor, profiles: dict[str, SensorDetector | str], poses: list[Pose]
) -> tuple[list[Step], list[np.ndarray]]:
    """Steps of a run and their images."""
    steps, images = [], []
    live.reset()
    for gap, x, twist in poses:
        start, worked = time.perf_counter(), time.process_time()
        live.move_to(gap_mm=gap, x_mm=x, twist_deg=twist)
        solved = time.perf_counter()
        frame = live.frame()
        ended, spent = time.perf_counter(), time.process_time() - worked
        verdicts = dict.fromkeys(profiles, "none")
        for name, each in profiles.items():
            if not isinstance(each, str):
                said = each.verdict(frame.image)
                verdicts[name] = f"{said.proximity} {said.combined}"
        steps.append(
            Step(
                solve_s=round(solved - start, 3), light_s=round(ended - solved, 3), cpu_s=round(spent, 3),
                force_n=tuple(round(value, 4) for value in frame.truth.force_n),  # type: ignore[arg-type]
                iterations=frame.truth.solve.iterations, verdicts=verdicts, in_contact=frame.truth.contact,
            )
        )  # fmt: skip
        images.append(frame.image)
    return steps, images


def rates(runs: dict[str, list[Step]]) -> dict[str, float]:
    """Medians over the steps of all runs in contact and out of it."""
    steps = [step for run in runs.values() for step in run]
    found = {}
    for name, chosen in (
        ("contact", [s for s in steps if s.in_contact]),
        ("free", [s for s in steps if not s.in_contact]),
    ):
        solve, light = (statistics.median(getattr(step, field) for step in chosen) for field in ("solve_s", "light_s"))
        found |= {
            f"{name}_solve_s": round(solve, 3), f"{name}_light_s": round(light, 3),
            f"{name}_cpu_s": round(statistics.median(step.cpu_s for step in chosen), 3),
            f"{name}_frames_per_second": round(1 / (solve + light), 2),
            f"{name}_forces_per_second": round(1 / max(solve, 1e-4), 1),
        }  # fmt: skip
    return found


def compared(
    full: list[Step], control: list[Step], images: tuple[list[np.ndarray], list[np.ndarray]]
) -> dict[str, object]:
    """How far one run at quality `control` is from the same run in full."""
    grey = [float(np.abs(a.astype(float) - b.astype(float)).mean()) for a, b in zip(*images, strict=True)]
    wide = [float(np.percentile(np.abs(a.astype(float) - b.astype(float)), 99)) for a, b in zip(*images, strict=True)]
    force = [float(np.linalg.norm(np.subtract(a.force_n, b.force_n))) for a, b in zip(full, control, strict=True)]
    largest = max(float(np.linalg.norm(step.force_n)) for step in full)
    agree = {
        name: sum(a.verdicts[name] == b.verdicts[name] for a, b in zip(full, control, strict=True))
        for name in full[0].verdicts
    }
    return {
        "steps": len(full), "grey_mean": round(statistics.mean(grey), 2), "grey_99": round(max(wide), 1),
        "force_largest_n": round(max(force), 4), "force_of_largest": round(max(force) / largest, 4),
        "verdicts_agree": agree,
    }  # fmt: skip


def main() -> None:
    """Follows all runs at both qualities."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--scene", default="grip")
    parser.add_argument("--tier", default="true", help="tier of the frames at quality control; those in full are true")
    parser.add_argument("--set", dest="settings", action="append", default=[])
    options = parser.parse_args()
    steps: dict[str, dict[str, list[Step]]] = {}
    images: dict[str, dict[str, list[np.ndarray]]] = {}
    try:
        for quality, tier in (("full", "true"), ("control", options.tier)):
            steps[quality], images[quality] = {}, {}
            settings = [*options.settings, f"render.tier={tier}"]
            with live_sensor(options.scene, settings, workspace=SPACE, quality=quality) as live:
                profiles = untouched(live)
                for pose in ((0.5, 0.0, 0.0), (-0.2, 0.0, 0.0)):
                    live.move_to(gap_mm=pose[0], x_mm=pose[1], twist_deg=pose[2])
                    live.frame()
                for name, poses in RUNS.items():
                    steps[quality][name], images[quality][name] = follow(live, profiles, poses)
    except MagicsimError as error:
        raise SystemExit(f"control_loop: {error}") from error
    found = {
        "rates": {quality: rates(runs) for quality, runs in steps.items()},
        "errors": {
            name: compared(steps["full"][name], steps["control"][name], (images["full"][name], images["control"][name]))
            for name in RUNS
        },
        "steps": {q: {name: [asdict(step) for step in run] for name, run in runs.items()} for q, runs in steps.items()},
    }
    text = json.dumps(found, indent=1)
    if options.out is not None:
        options.out.write_text(text + "\n", encoding="utf-8")
    print(json.dumps({key: found[key] for key in ("rates", "errors")}, indent=1))


if __name__ == "__main__":
    main()
