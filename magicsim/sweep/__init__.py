"""Design sweeps: many sensors judged by the same measures, and a page to explore them.

`load_sweep` and `run_sweep` are loaded when they are first used.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.sweep_file import load_sweep

__all__ = ["load_sweep", "run_sweep"]

_HOMES = {"load_sweep": "magicsim.sweep.sweep_file", "run_sweep": "magicsim.sweep.comparison"}


def __getattr__(name: str) -> object:
    """Loads a public function from its module."""
    if name not in _HOMES:
        msg = f"module 'magicsim.sweep' has no attribute '{name}'"
        raise AttributeError(msg)
    function = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = function
    return function
