"""Versions that results depend on: a run goes on only where they are those that its folder was begun with."""

import importlib.metadata
from collections.abc import Mapping

import magicsim

PACKAGES = ("mitsuba", "drjit", "numpy", "scipy", "pyarrow", "opencv-contrib-python-headless")
"""Whose versions may change a result's bytes."""


def versions() -> dict[str, str]:
    """Versions of everything that a result's bytes depend on."""
    return {"magicsim": magicsim.__version__} | {name: importlib.metadata.version(name) for name in PACKAGES}


def changed_versions(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names that have another version now, or that only one of both knows."""
    return sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))
