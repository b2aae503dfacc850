"""Datasets: a recipe becomes shards of labelled frames, recorded frames become the same, training loops read them.

The names below are loaded when they are first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.dataset.frames import open_frames
    from magicsim.dataset.real.description import RealSource, load_real
    from magicsim.dataset.real.inspection import inspect_real
    from magicsim.dataset.real.writing import write_real

__all__ = ["RealSource", "inspect_real", "load_real", "open_frames", "write_real"]

_HOMES = {
    "RealSource": "magicsim.dataset.real.description",
    "inspect_real": "magicsim.dataset.real.inspection",
    "load_real": "magicsim.dataset.real.description",
    "open_frames": "magicsim.dataset.frames",
    "write_real": "magicsim.dataset.real.writing",
}

__getattr__, __dir__ = lazy_names("magicsim.dataset", _HOMES)
