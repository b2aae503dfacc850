"""Parts that may be missing on a machine, what each is for, and how to get it."""

import importlib.util
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A part that one job needs."""

    name: str
    installed: bool
    without: str
    """What its absence costs."""
    get: str
    """How to get it; where it comes with the program, for which machines there is one."""


OPTIONAL = (
    (
        "PARDISO",
        "pypardiso",
        "SuperLU solves contact: forces within tolerance of the same, in five times the processor time",
        "x86-64 only",
    ),
    ("lib3mf", "lib3mf", "no export to .3mf; .stl and .glb remain", "not for Linux on ARM"),
    ("video", "av", "no H.264 camera (rig.camera.compression), no videos with time stamps (magicsim real)", "video"),
    ("robot", "gymnasium", "no Gymnasium environment; LiveSensor and DigitCamera remain", "robot"),
    ("mujoco", "mujoco", "no sensors on a MuJoCo model (magicsim.robot.mujoco)", "mujoco"),
    ("live", "viser", "no live window (magicsim live)", "live"),
    ("search", "optuna", 'no sweeps with sampling = "search"', "search"),
    ("torch", "torch", "no magicsim.dataset.torch; magicsim.dataset.frames remains", "torch"),
    ("hf", "datasets", "Hugging Face's reader of datasets; any Parquet reader remains", "hf"),
    ("hdf5", "h5py", "no export to HDF5", "hdf5"),
    ("zarr", "zarr", "no export to Zarr", "zarr"),
    ("webdataset", "webdataset", "WebDataset's reader; its tar files are written without it", "webdataset"),
    ("mcap", "foxglove", "no MCAP files (simulate --mcap, dataset export)", "mcap"),
    ("cluster", "distributed", "no --cluster; processes on this machine remain", "cluster"),
)
"""Name, module, cost of its absence, and the extra that brings it or for which machines there is one."""
EXTRAS = frozenset(
    {"video", "robot", "mujoco", "live", "search", "torch", "hf", "hdf5", "zarr", "webdataset", "mcap"} | {"cluster"}
)


def optional_parts() -> list[Part]:
    """Every optional part, installed or not."""
    return [
        Part(
            name=name,
            installed=importlib.util.find_spec(module) is not None,
            without=cost,
            get=f"pip install 'magicsim[{source}]'" if source in EXTRAS else f"comes with magicsim ({source})",
        )
        for name, module, cost, source in OPTIONAL
    ]
