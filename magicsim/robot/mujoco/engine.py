"""MuJoCo itself, where it is installed."""

from typing import Any

from magicsim.errors import ConfigError

MjModel = Any
"""`mujoco.MjModel`; its attributes are those of MuJoCo's C structure."""
MjData = Any
"""`mujoco.MjData`."""
MjSpec = Any
"""`mujoco.MjSpec`."""


def engine() -> Any:  # noqa: ANN401 -- a module
    """The package `mujoco`.

    Raises:
        ConfigError: It is not installed.
    """
    try:
        import mujoco
    except ImportError:
        msg = "magicsim.robot.mujoco needs the package mujoco, which is not installed: pip install 'magicsim[mujoco]'"
        raise ConfigError(msg) from None
    return mujoco
