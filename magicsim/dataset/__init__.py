"""Datasets: a recipe becomes shards of labelled frames, recorded frames become the same, training loops read them.

Its names, which `__init__.pyi` lists, are loaded when they are first used, so that importing the package stays light.
"""

from magicsim.names import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
