"""Design sweeps: many sensors judged by the same measures, and a page to explore them.

Its names, which `__init__.pyi` lists, are loaded when they are first used.
"""

from magicsim.names import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
