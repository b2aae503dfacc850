"""magicsim: a physics-based simulator of the mini-MagicTac see-through touch sensor.

Its names, which `__init__.pyi` lists, are loaded when they are first used, so that importing the package stays light.
"""

import os

from magicsim.conventions import MAX_PIXELS
from magicsim.names import stub_names

os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_PIXELS))  # OpenCV reads it when it is loaded

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = stub_names(__name__)
