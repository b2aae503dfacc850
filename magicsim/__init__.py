"""magicsim: a physics-based simulator of the mini-MagicTac see-through touch sensor."""

__version__ = "0.1.0"
