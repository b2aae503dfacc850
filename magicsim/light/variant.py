"""Chooses the Mitsuba variant once per process: LLVM if this machine really runs it, scalar otherwise.

An unsuitable libLLVM can abort the whole process (measured with LLVM 15), so each candidate is probed in a
subprocess first.
"""

import functools
import importlib.metadata
import logging
import os
import subprocess
import sys
from pathlib import Path

from magicsim.errors import ConfigError, unknown_choice
from magicsim.folder import check_current_folder

LLVM_VARIANT = "llvm_ad_rgb"
CUDA_VARIANT = "cuda_ad_rgb"
SCALAR_VARIANT = "scalar_rgb"
VARIANTS = (LLVM_VARIANT, CUDA_VARIANT, SCALAR_VARIANT)
LLVM_PACKAGE = "karellen-llvm-core"
LLVM_VARIABLE = "DRJIT_LIBLLVM_PATH"
VARIANT_VARIABLE = "MAGICSIM_VARIANT"
"""Environment variable that names the variant and skips the probe; worker processes inherit it."""

_PROBE = (
    "import mitsuba as mi; mi.set_variant('llvm_ad_rgb'); import drjit as dr; "
    "assert dr.sum(dr.arange(mi.Float, 1000))[0] == 499500"
)
_log = logging.getLogger(__name__)


def find_llvm() -> Path | None:
    """The libLLVM to use: the one named in the environment, or the one that the Python package brought."""
    named = os.environ.get(LLVM_VARIABLE)
    if named:
        return Path(named)
    try:
        files = importlib.metadata.files(LLVM_PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.name.startswith("libLLVM.so."):
            return Path(str(file.locate())).resolve()
    return None


def probe_llvm(library: Path) -> str | None:
    """Runs a small LLVM kernel in a subprocess; None if it worked, else the reason."""
    environment = {**os.environ, LLVM_VARIABLE: str(library)}
    command = [sys.executable, "-c", _PROBE]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"the probe ended with code {done.returncode}"


@functools.cache
def activate_variant() -> str:
    """Sets the Mitsuba variant of this process and returns its name. The only place that does.

    Raises:
        ConfigError: The environment names another variant than `VARIANTS`, or one that does not run here.
        OutputError: The current folder is gone.
    """
    check_current_folder()
    variant = os.environ.get(VARIANT_VARIABLE) or _choose()
    if variant not in VARIANTS:
        raise ConfigError(unknown_choice(f"variant ({VARIANT_VARIABLE})", variant, VARIANTS))
    os.environ[VARIANT_VARIABLE] = variant
    library = find_llvm()
    if variant == LLVM_VARIANT and library is not None:
        os.environ[LLVM_VARIABLE] = str(library)
    import mitsuba as mi

    try:
        mi.set_variant(variant)
    except ImportError as error:
        raise ConfigError(f"{VARIANT_VARIABLE} = {variant} does not run here: {str(error).splitlines()[0]}") from error
    if variant == LLVM_VARIANT and library is not None and (other := _other_llvm(library)) is not None:
        raise ConfigError(
            f"mitsuba or drjit was imported before magicsim and has loaded {other}, which can end the process: import "
            f"magicsim.light.backend first, or set {LLVM_VARIABLE}={library} before Python starts"
        )
    return variant


def _other_llvm(library: Path) -> str | None:
    """The libLLVM that Dr.Jit has loaded instead of one, None where it is that one or cannot be known.

    Dr.Jit loads it when it is first imported and never another one.
    """
    maps = Path("/proc/self/maps")
    if not maps.is_file() or library.name == str(library):  # a bare name is looked for by the system
        return None
    loaded = {line.split()[-1] for line in maps.read_text().splitlines() if "/libLLVM" in line}
    return None if not loaded or str(library.resolve()) in loaded else min(loaded)


def offered_variants() -> list[str]:
    """Members of `VARIANTS` that the installed Mitsuba brings, whether they run here or not; it is not loaded."""
    brought = {file.name.partition(".")[0] for file in importlib.metadata.files("mitsuba") or ()}
    return [name for name in VARIANTS if name in brought]


def _choose() -> str:
    library = find_llvm()
    reason = "no libLLVM was found" if library is None else probe_llvm(library)
    if reason is None:
        return LLVM_VARIANT
    _log.warning(
        "rendering with %s, many times slower, because %s; `pip install %s` brings LLVM on Linux",
        SCALAR_VARIANT,
        reason,
        LLVM_PACKAGE,
    )
    return SCALAR_VARIANT
