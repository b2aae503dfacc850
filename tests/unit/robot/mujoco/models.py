"""Models of a few bodies; who imports this is skipped where MuJoCo is missing."""

from typing import Any

import pytest

mujoco = pytest.importorskip("mujoco")


def body(geoms: str, *, option: str = "", assets: str = "") -> Any:
    """A model of a table with a sensor, face up, and one free body."""
    return mujoco.MjSpec.from_string(f"""<mujoco><option timestep="0.001" {option}/><asset>{assets}</asset><worldbody>
        <body name="table"><site name="sensor" quat="0 1 0 0"/><geom type="box" size=".006 .008 .003" pos="0 0 -.003"/>
        </body><body name="thing" pos="0 0 .02"><freejoint/>{geoms}</body></worldbody></mujoco>""")
