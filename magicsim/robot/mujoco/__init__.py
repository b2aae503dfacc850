"""Sensors on a MuJoCo model: body poses in, contact wrenches and frames out.

Needs the extra `mujoco`. Its names, which `__init__.pyi` lists, are loaded when they are first used.
"""

from magicsim.names import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
