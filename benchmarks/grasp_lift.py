"""What a step of `GraspLift-v0` costs, with the pictures of both fingers and of one, at each quality.

    python benchmarks/grasp_lift.py --out docs/benchmarks/grasp-lift.json

The policy of `docs/examples/lift_without_slip.py` plays one episode for each, in this process, after another episode
that compiles and records. `solve_s` and `light_s` are seconds of a clock on the wall, which other work stretches;
`cpu_s` is what all threads of this process worked, which it hardly does.
"""

import argparse
import json
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.errors import MagicsimError
from magicsim.robot import GraspLift

GRIP_MM, SLIDING_SHARE = 0.4, 0.6
"""Depth of the first grip [mm], and share of the contact that slides at which the grip is tightened."""
START = {"weight_n": 1.5, "gap_mm": 0.3, "x_mm": 0.2, "y_mm": 0.0, "z_mm": 0.1}
SETTINGS = {"both": {}, "one picture": {"cameras": 1}, "both, control": {"quality": "control"}}


def played(env: GraspLift, *, seed: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Every step's cost and state, and the last step's info."""
    _, info = env.reset(seed=seed, options=START)
    steps, is_over = [], False
    while not is_over:
        is_touching = -info["gap_mm"] >= GRIP_MM - 1e-6
        closing = 0.0 if is_touching and info["slip_share"] < SLIDING_SHARE else 0.5
        rising = 0.6 if is_touching and info["object_mm"] < env.target_mm else 0.0
        worked = time.process_time()
        _, _, is_done, is_late, info = env.step(np.array([closing, rising], np.float32))
        steps.append(
            {
                "hold": info["hold"], "in_contact": info["normal_n"] > 0, "solve_s": round(env.cost.solve_s, 3),
                "light_s": round(env.cost.light_s, 3), "cpu_s": round(time.process_time() - worked, 3),
            }
        )  # fmt: skip
        is_over = is_done or is_late
    return steps, info


def medians(steps: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """By where the object is: on the table untouched, on the table pressed, between the fingers."""
    where = {
        "free": [step for step in steps if not step["in_contact"]],
        "pressed": [step for step in steps if step["in_contact"] and step["hold"] == "placed"],
        "held": [step for step in steps if step["hold"] in {"held", "slipped"}],
    }
    return {
        name: {
            field: round(statistics.median(step[field] for step in chosen), 3)
            for field in ("solve_s", "light_s", "cpu_s")
        }
        | {"steps": len(chosen)}
        for name, chosen in where.items()
        if chosen
    }


def main() -> None:
    """Plays an episode with each setting."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--set", dest="overrides", action="append", default=[])
    options = parser.parse_args()
    found: dict[str, Any] = {}
    try:
        for name, settings in SETTINGS.items():
            env = GraspLift(overrides=options.overrides, **settings)
            env.reset(seed=0, options=START | {"gap_mm": 0.1})
            for _ in range(2):
                env.step(np.array([0.7, 0.3], np.float32))
            steps, info = played(env, seed=0)
            env.close()
            found[name] = {"medians": medians(steps), "is_success": info["is_success"], "steps": steps}
    except MagicsimError as error:
        raise SystemExit(f"grasp_lift: {error}") from error
    if options.out is not None:
        options.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(json.dumps({name: {key: each[key] for key in ("medians", "is_success")} for name, each in found.items()}))


if __name__ == "__main__":
    main()
