"""Configuration: TOML files and presets become checked, frozen models; whatever is wrong is one line.

`load_preset` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.config.models import load_preset

__all__ = ["load_preset"]


def __getattr__(name: str) -> object:
    """Loads the public name from its module."""
    if name != "load_preset":
        msg = f"module 'magicsim.config' has no attribute '{name}'"
        raise AttributeError(msg)
    from magicsim.config.models import load_preset

    return load_preset
