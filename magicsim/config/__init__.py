"""Configuration: TOML files and presets become checked, frozen models; whatever is wrong is one line.

`load_preset` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.config.models import load_preset

__all__ = ["load_preset"]

__getattr__, __dir__ = lazy_names("magicsim.config", {"load_preset": "magicsim.config.models"})
