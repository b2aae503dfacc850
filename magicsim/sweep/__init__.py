"""Design sweeps: many sensors judged by the same measures, and a page to explore them.

`load_sweep` and `run_sweep` are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.sweep_file import load_sweep

__all__ = ["load_sweep", "run_sweep"]
_HOMES = {"load_sweep": "magicsim.sweep.sweep_file", "run_sweep": "magicsim.sweep.comparison"}
__getattr__, __dir__ = lazy_names("magicsim.sweep", _HOMES)
