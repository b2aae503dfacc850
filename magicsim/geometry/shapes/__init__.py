"""Rigid solids as signed distance, normal, support and mesh.

`Shape` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.geometry.shapes.solids import Shape

__all__ = ["Shape"]

__getattr__, __dir__ = lazy_names("magicsim.geometry.shapes", {"Shape": "magicsim.geometry.shapes.solids"})
