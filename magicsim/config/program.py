"""What computes a result: sources of this program, libraries that numbers come from, and the variant that renders.

Whatever keeps results to use them again has this in its key or beside them: untouched sensors, takes, baselines, and
folders that grow over several runs. `magicsim.__version__` stays while sources change. The whole package counts, though
some files reach no frame: which ones do changes with every patch, and what is made once too often costs time alone.
"""

import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from magicsim.config.presets import preset_root

LIBRARIES = (
    "mitsuba", "drjit", "karellen-llvm-core", "numpy", "scipy", "numba", "llvmlite", "manifold3d", "libigl", "trimesh",
    "lib3mf", "pypardiso", "mkl", "pillow", "opencv-contrib-python-headless", "onnxruntime", "pyarrow", "av",
)  # fmt: skip
"""Distributions whose versions may change a result's bytes; those that are not installed are left out."""
BESIDE = ("scenes/rooms", "scenes/models")
"""What comes with the program, and configurations know by name alone or not at all: pictures of rooms, models."""
SOURCES = "sources"
"""Key of the sources' digest beside the versions."""
DIGITS = 16
"""Hexadecimal digits of it."""


@cache
def versions(*beside: str) -> dict[str, str]:
    """Version, digest of sources, rooms and models, those of `beside` too, and versions of libraries, by name."""
    import magicsim
    from magicsim.kernels import package_hash

    sources = hashlib.sha256(package_hash().encode())
    for folder in BESIDE:
        for path in sorted((preset_root() / folder).glob("*")):
            sources.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    found = {"magicsim": magicsim.__version__, SOURCES: sources.hexdigest()[:DIGITS]}
    for name in beside:
        found[name] = package_hash(Path(str(import_module(name).__file__)).parent)[:DIGITS]
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def program_key(variant: str) -> str:
    """Digest of everything beside a configuration that decides a result, where Mitsuba renders with a variant."""
    return hashlib.sha256(json.dumps([versions(), variant], sort_keys=True).encode()).hexdigest()


def changed_versions(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names that have another version now, or that only one of both knows."""
    return sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))


def other_code(before: Mapping[str, str], now: Mapping[str, str]) -> str | None:
    """What made an earlier result, where that is not what would make it now: `sources, numpy`, or unknown code."""
    if SOURCES not in before:
        return "unknown code (it does not say of which sources)"
    changed = changed_versions(before, now)
    return f"another version of {', '.join(changed)}" if changed else None
