"""Rigid solids as signed distance, normal, support and mesh."""

from magicsim.geometry.shapes.solids import Shape

__all__ = ["Shape"]
