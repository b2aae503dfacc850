"""What this machine can do, found by trying it."""

import importlib.util
import os
import platform
from dataclasses import dataclass

from magicsim.cli.answers.parts import Part, optional_parts
from magicsim.light.records.untouched_store import default_store
from magicsim.light.variant import (
    LLVM_PACKAGE,
    LLVM_VARIANT,
    SCALAR_VARIANT,
    VARIANT_VARIABLE,
    find_llvm,
    offered_variants,
    probe_llvm,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Examination:
    """What `magicsim doctor` reports."""

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
    problems: list[str]
    """What is slower or missing than it could be, and how to get it."""
    parts: list[Part]
    """Every optional part: whether it is there, what its absence costs, how to get it."""


def examine(*, clear_cache: bool = False) -> Examination:
    """Looks for LLVM by running it in a subprocess, and for the fast sparse solver.

    Args:
        clear_cache: Whether to remove what is kept of untouched sensors.
    """
    problems, store = [], default_store()
    if store is not None and clear_cache:
        store.clear()
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
        cores=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        platform=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        cache=str(store.folder) if store is not None else None,
        cache_bytes=store.size_bytes() if store is not None else 0,
        problems=problems,
        parts=optional_parts(),
    )
