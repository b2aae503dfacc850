from magicsim.sweep.comparison import run_sweep
from magicsim.sweep.sweep_file import load_sweep

__all__ = ["load_sweep", "run_sweep"]
