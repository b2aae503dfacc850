"""Rigid solids as signed distance, normal, support and mesh.

`Shape` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.geometry.shapes.solids import Shape

__all__ = ["Shape"]


def __getattr__(name: str) -> object:
    """Loads the public name from its module."""
    if name != "Shape":
        msg = f"module 'magicsim.geometry.shapes' has no attribute '{name}'"
        raise AttributeError(msg)
    from magicsim.geometry.shapes.solids import Shape

    return Shape
