"""What the coupling to MuJoCo approximates, measured: rest, energy, momentum, and what the linear answer misses.

    python benchmarks/mujoco_contact.py --out docs/benchmarks/mujoco-contact.json      # extra `mujoco`

A ball falls 0.5 mm on a sensor that lies on a table and comes to rest there; and it meets a sensor that flies freely,
without gravity, and parts from it again. Nothing is rendered. The sensor is `mini-magictac` with
the friction of the scene `grip`.
"""

import argparse
import json
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import mujoco
import numpy as np

from magicsim.robot.mujoco import Coupling, Touch, compiled
from magicsim.scenes.scene import load_scene

RADIUS_M, MASS_KG, DROP_M, SPEED_M_S = 0.010, 0.030, 0.0005, 0.1
TOUCHES = [Touch(site="sensor", body="ball", x_mm=(-4, 4), y_mm=(-4, 4))]
BALL = f"<freejoint/><geom type='sphere' size='{RADIUS_M}' mass='{MASS_KG}'/>"
PAD = "<geom type='box' size='.012 .016 .0033' mass='.1'/>"
ON_A_TABLE = f"""<mujoco><option timestep="{{step}}"/><worldbody>
  <body name="pad"><site name="sensor" pos="0 0 .0033" quat="0 1 0 0"/>{PAD}</body>
  <body name="ball" pos="0 0 {RADIUS_M + DROP_M + 0.0033}">{BALL}</body></worldbody></mujoco>"""
FLYING = f"""<mujoco><option timestep="{{step}}" gravity="0 0 0"/><worldbody>
  <body name="pad"><freejoint/><site name="sensor" pos="0 0 .0033" quat="0 1 0 0"/>{PAD}</body>
  <body name="ball" pos="0.0005 0 {RADIUS_M + 0.0001 + 0.0033}">{BALL}</body></worldbody></mujoco>"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One episode."""

    tolerance_n: float
    timestep_s: float
    solves: int
    """Solves of the contact."""
    steps: int
    """Steps of MuJoCo."""
    worst_n: float
    """Largest error of a linear answer, seen at the solve that followed it [N]."""
    seconds: float
    """On the wall, building excluded [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest(Run):
    """A ball at rest on the sensor."""

    weight_n: float
    answered_n: float
    """Normal force that the model felt [N]."""
    solved_n: float
    """Normal force of an equilibrium solved in the last pose [N]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rebound(Run):
    """A collision."""

    energy_kept: float
    """Kinetic energy of both after over before."""
    momentum_error: float
    """Change of the linear momentum of both in units of the ball's."""


def coupled(xml: str, *, tolerance_n: float, step_s: float, damping_s: float) -> Coupling:
    """A model with its sensor."""
    model = compiled(mujoco.MjSpec.from_string(xml.format(step=step_s)), TOUCHES)
    return Coupling(
        model, mujoco.MjData(model), TOUCHES, scene=load_scene("grip"), tolerance_n=tolerance_n, damping_s=damping_s
    )


def figures(coupling: Coupling, steps: int, seconds: float, tolerance_n: float) -> dict[str, float]:
    """What every run reports."""
    sensor = coupling.sensors["sensor"]
    return {
        "tolerance_n": tolerance_n, "timestep_s": float(coupling.model.opt.timestep), "solves": sensor.solves,
        "steps": steps, "worst_n": sensor.trust.worst_n, "seconds": seconds,
    }  # fmt: skip


def rest(tolerance_n: float, step_s: float) -> Rest:
    """The ball is caught, and lies still after 0.4 s."""
    coupling = coupled(ON_A_TABLE, tolerance_n=tolerance_n, step_s=step_s, damping_s=0.01)
    start, steps = time.perf_counter(), round(0.4 / step_s)
    for _ in range(steps):
        coupling.step()
    seconds, answered = time.perf_counter() - start, float(coupling.wrench("sensor")[2])
    run = figures(coupling, steps, seconds, tolerance_n)
    sensor = coupling.sensors["sensor"]
    sensor.solve(sensor.pose(coupling.data))
    return Rest(**run, weight_n=MASS_KG * 9.81, answered_n=answered, solved_n=float(sensor.deformation.force_n[2]))  # type: ignore[arg-type]


def collide(tolerance_n: float, step_s: float, damping_s: float) -> Rebound:
    """Ball and sensor fly freely and part again."""
    coupling = coupled(FLYING, tolerance_n=tolerance_n, step_s=step_s, damping_s=damping_s)
    model, data = coupling.model, coupling.data
    data.qvel[6:9] = (0.0, 0.0, -SPEED_M_S)
    whole, start, steps = MASS_KG * SPEED_M_S, time.perf_counter(), round(0.06 / step_s)
    for _ in range(steps):
        coupling.step()
    seconds = time.perf_counter() - start
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    linear = float(model.body_subtreemass[0]) * data.subtree_linvel[0]
    return Rebound(
        **figures(coupling, steps, seconds, tolerance_n),
        energy_kept=float(data.qvel @ mass @ data.qvel) / (MASS_KG * SPEED_M_S**2),
        momentum_error=float(np.linalg.norm(linear - [0, 0, -whole])) / whole,
    )  # type: ignore[arg-type]


def main() -> None:
    """Runs everything and writes the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    out: Path = parser.parse_args().out
    tolerances = (0.05, 0.02, 0.005)
    results = {
        "rest": [asdict(rest(each, 0.001)) for each in tolerances] + [asdict(rest(0.02, 0.002))],
        "flying, elastic": [asdict(collide(each, 0.0005, 0.0)) for each in tolerances]
        + [asdict(collide(0.02, each, 0.0)) for each in (0.001, 0.00025)],
        "flying, damping 5 ms": [asdict(collide(0.02, 0.0005, 0.005))],
    }
    out.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    for name, runs in results.items():
        for run in runs:
            sys.stdout.write(f"{name}: " + ", ".join(f"{key} {value:.4g}" for key, value in run.items()) + "\n")


if __name__ == "__main__":
    main()
