from magicsim.dataset.frames import open_frames
from magicsim.dataset.real.description import RealSource, load_real
from magicsim.dataset.real.inspection import inspect_real
from magicsim.dataset.real.writing import write_real

__all__ = ["RealSource", "inspect_real", "load_real", "open_frames", "write_real"]
