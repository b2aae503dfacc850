"""What this machine can do, found by trying it."""

import importlib.util
import os
import platform
from dataclasses import dataclass

from magicsim.folder.kept import TAKES, frames_folder, kept_copies, kept_takes
from magicsim.light.records.untouched import default_store
from magicsim.light.variant import (
    LLVM_PACKAGE,
    LLVM_VARIANT,
    SCALAR_VARIANT,
    VARIANT_VARIABLE,
    find_llvm,
    offered_variants,
    probe_llvm,
)
from magicsim.workers.attempt import usable_cores


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
    ("video", "av", "no H.264 camera (rig.camera.compression), no videos with time stamps (dataset import)", "video"),
    ("robot", "gymnasium", "no Gymnasium environment; LiveSensor and DigitCamera remain", "robot"),
    ("mujoco", "mujoco", "no sensors on a MuJoCo model (magicsim.robot.mujoco)", "mujoco"),
    ("live", "viser", "no live window (magicsim live)", "live"),
    ("search", "optuna", 'no sweeps with sampling = "search"', "search"),
    ("distil", "onnx", "no models of the fast tier; those that are made run", "distil"),
    ("torch", "torch", "no magicsim.dataset.torch; magicsim.dataset.frames remains", "torch"),
    ("hf", "datasets", "Hugging Face's reader of datasets; any Parquet reader remains", "hf"),
    ("hdf5", "h5py", "no export to HDF5", "hdf5"),
    ("zarr", "zarr", "no export to Zarr", "zarr"),
    ("webdataset", "webdataset", "WebDataset's reader; its tar files are written without it", "webdataset"),
    ("mcap", "foxglove", "no MCAP files (simulate --mcap, dataset export)", "mcap"),
    ("cluster", "distributed", "no --cluster; processes on this machine remain", "cluster"),
)
"""Name, module, cost of its absence, and the extra that brings it or for which machines there is one."""
EXTRAS = frozenset(source for *_, source in OPTIONAL if " " not in source)


def optional_parts() -> list[Part]:
    """Every optional part, installed or not."""
    return [
        Part(
            name=name, installed=importlib.util.find_spec(module) is not None, without=cost,
            get=f"pip install 'magicsim[{source}]'" if source in EXTRAS else f"comes with magicsim ({source})",
        )
        for name, module, cost, source in OPTIONAL
    ]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Examination:
    """What `magicsim info doctor` reports."""

    variant: str
    """Mitsuba variant that will render; `MAGICSIM_VARIANT` asks for another."""
    can_ask_for: list[str]
    """Variants that the installed Mitsuba offers: `cuda_ad_rgb` needs an NVIDIA GPU."""
    llvm: str | None
    """The libLLVM that works, or None."""
    solver: str
    """Sparse factorisation that will be used."""
    cores: int
    """Processors that this process may use."""
    platform: str
    cache: str | None
    """Folder that keeps untouched sensors, so that they are rendered once; None where it is switched off."""
    cache_bytes: int
    """What it holds [bytes]."""
    takes_bytes: int
    """Size of the takes in `magicsim-takes`, below the current folder [bytes]."""
    frames_bytes: int
    """Size of the mapped copies of datasets' frames [bytes]."""
    problems: list[str]
    """What is slower or missing than it could be, and how to get it."""
    parts: list[Part]
    """Every optional part: whether it is there, what its absence costs, how to get it."""


def examine(*, clear_cache: bool = False) -> Examination:
    """Looks for LLVM by running it in a subprocess, and for the fast sparse solver.

    `clear_cache` removes what is kept: untouched sensors, takes below this folder, copies of frames.
    """
    problems, store, takes, frames = [], default_store(), kept_takes(TAKES), frames_folder()
    copies = kept_copies(frames) if frames is not None else None
    for each in (store, takes, copies) if clear_cache else ():
        if each is not None:
            each.clear()
    library = find_llvm()
    reason = "no libLLVM was found" if library is None else probe_llvm(library)
    if reason is not None:
        problems.append(
            f"rendering is many times slower without LLVM ({reason}); `pip install {LLVM_PACKAGE}` on Linux"
        )
    fast = importlib.util.find_spec("pypardiso") is not None
    if not fast:
        problems.append("solving takes five times as long without PARDISO; `pip install pypardiso` on x86-64")
    return Examination(
        variant=os.environ.get(VARIANT_VARIABLE) or (LLVM_VARIANT if reason is None else SCALAR_VARIANT),
        can_ask_for=offered_variants(),
        llvm=library.name if reason is None and library is not None else None,
        solver="PARDISO" if fast else "SuperLU",
        cores=usable_cores(),
        platform=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        cache=str(store.folder) if store is not None else None,
        cache_bytes=store.size_bytes() if store is not None else 0,
        takes_bytes=takes.size_bytes(),
        frames_bytes=copies.size_bytes() if copies is not None else 0,
        problems=problems,
        parts=optional_parts(),
    )
