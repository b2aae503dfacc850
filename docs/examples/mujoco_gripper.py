"""A two-finger gripper in MuJoCo, one see-through sensor on each finger, lifts a ball.

python docs/examples/mujoco_gripper.py      # needs the extra `mujoco`; writes mujoco-gripper.png
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np

from magicsim.robot.mujoco import Coupling, Touch, compiled
from magicsim.robot.quality import CONTROL_QUALITY
from magicsim.scenes.scene import SceneConfig, load_scene

RADIUS_M, MASS_KG, STAND_M = 0.010, 0.030, 0.006
"""Ball, and the stand that it lies on."""
PICTURES = replace(CONTROL_QUALITY, name="pictures", render={}, bounds={})
"""Solved as for control, rendered in full."""
CLOSE_S, LIFT_S, HOLD_S = 0.25, 0.35, 0.25
CLOSED_M, LIFTED_M = 0.0035, 0.015
"""Way of each finger beyond where it touches if the ball would give way, and way upwards."""
FINGER = """
<body name="{name}" pos="{side}0.016 0 0">
  <joint name="{name}" type="slide" axis="{inward} 0 0" damping="4" armature="0.05" range="0 0.02"/>
  <geom name="{name}-pad" type="box" size="0.0033 0.012 0.016" pos="{side}0.0033 0 0" mass="0.02"/>
  <geom name="{name}-back" type="box" size="0.004 0.012 0.016" pos="{side}0.0106 0 0" mass="0.03"/>
  <site name="{name}" xyaxes="0 {across} 0 0 0 1"/>
</body>
"""
MODEL = """
<mujoco model="gripper">
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <light pos="0 0 1"/>
    <geom name="floor" type="plane" size="0.2 0.2 0.01"/>
    <geom name="stand" type="cylinder" size="0.004 {half_stand}" pos="0 0 {half_stand}"/>
    <body name="ball" pos="0 0 {height}">
      <freejoint/>
      <geom type="sphere" size="{radius}" mass="{mass}" rgba="1 0.5 0.1 1" condim="4" friction="1 0.005 0.0001"/>
    </body>
    <body name="wrist" pos="0 0 {wrist}">
      <joint name="lift" type="slide" axis="0 0 1" damping="30" armature="0.5"/>
      <geom name="palm" type="box" size="0.04 0.012 0.005" pos="0 0 0.03" mass="0.2" contype="0" conaffinity="0"/>
      {left}{right}
    </body>
  </worldbody>
  <actuator>
    <position name="left" joint="left" kp="600" forcerange="-3 3"/>
    <position name="right" joint="right" kp="600" forcerange="-3 3"/>
    <position name="lift" joint="lift" kp="4000"/>
  </actuator>
</mujoco>
"""
TOUCHES = (
    Touch(site="left", body="ball", faces="right", x_mm=(-4, 4), y_mm=(-4, 4)),
    Touch(site="right", body="ball", faces="left", x_mm=(-4, 4), y_mm=(-4, 4)),
)


def build() -> mujoco.MjModel:
    """The compiled model, MuJoCo's own contact between ball and fingers left out."""
    height = STAND_M + RADIUS_M
    xml = MODEL.format(
        half_stand=STAND_M / 2, radius=RADIUS_M, mass=MASS_KG, height=height, wrist=height + 0.001,
        left=FINGER.format(name="left", side="-", inward=1, across=-1),
        right=FINGER.format(name="right", side="", inward=-1, across=1),
    )  # fmt: skip
    return compiled(mujoco.MjSpec.from_string(xml), TOUCHES)


def targets(time_s: float) -> tuple[float, float, float]:
    """Where left finger, right finger and wrist are to be [m]: close, then lift, then hold."""
    closing = min(time_s / CLOSE_S, 1.0)
    lifting = min(max(time_s - CLOSE_S, 0.0) / LIFT_S, 1.0)
    finger = closing * (0.016 - RADIUS_M + CLOSED_M)
    return finger, finger, lifting * LIFTED_M


def run(scene: SceneConfig, *, pictures: bool = True, seconds: float = CLOSE_S + LIFT_S + HOLD_S) -> dict[str, Any]:
    """Plays the episode.

    Args:
        scene: Sensor, friction and render settings.
        pictures: Whether the first and the last frame are rendered; forces come without.
        seconds: How long.

    Returns:
        `height_mm`: rise of the ball; `weight_n`; `carried_n`: upward force of both sensors at the end;
        `rows`: time, forces and height of every frame; `images`: of each sensor at the first and at the last frame.
    """
    model = build()
    data = mujoco.MjData(model)
    coupling = Coupling(model, data, TOUCHES, scene=scene, quality=PICTURES if pictures else "control")
    start, rows, taken = float(data.qpos[2]), [], []
    while data.time < seconds:
        data.ctrl[:] = targets(data.time)
        moments = coupling.step()
        if moments is None:
            continue
        truths = coupling.truths(moments)
        rise_mm = 1000 * (float(data.qpos[2]) - start)
        forces = {name: truth.force_n for name, truth in truths.items()}
        rows.append({"time_s": float(data.time), "rise_mm": rise_mm, **forces})
        taken.append(moments)
    carried = -sum(coupling.wrench(name)[1] for name in coupling.sensors)
    return {
        "height_mm": 1000 * (float(data.qpos[2]) - start),
        "weight_n": MASS_KG * 9.81,
        "carried_n": float(carried),
        "rows": rows,
        "images": [
            [frame.image for frame in coupling.develop(moments).values()]
            for moments in ((taken[0], taken[-1]) if pictures else ())
        ],
        "solves": {name: sensor.solves for name, sensor in coupling.sensors.items()},
        "worst_n": {name: sensor.trust.worst_n for name, sensor in coupling.sensors.items()},
    }


def main() -> None:
    """Lifts the ball; writes a line for each frame, and both sensors open and gripping."""
    end = run(load_scene("grip"))
    for row in end["rows"]:
        sys.stdout.write(
            f"{row['time_s']:.3f} s: rise {row['rise_mm']:6.2f} mm, normal forces {row['left'][2]:.2f} and "
            f"{row['right'][2]:.2f} N, upward {-row['left'][1] - row['right'][1]:.3f} N\n"
        )
    sys.stdout.write(f"weight {end['weight_n']:.3f} N, carried {end['carried_n']:.3f} N\n")
    row = np.concatenate([each for pair in end["images"] for each in pair], axis=1)
    cv2.imwrite(str(Path("mujoco-gripper.png")), row[..., ::-1])


if __name__ == "__main__":
    main()
