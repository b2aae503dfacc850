"""A window in the browser on one live sensor: the object is dragged and pressed, the camera's frame follows.

Needs the extra `live` (viser). Its names, which `__init__.pyi` lists, are loaded when they are first used.
"""

from magicsim.names import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
