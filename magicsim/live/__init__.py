"""A window in the browser on one live sensor: the object is dragged and pressed, the camera's frame follows.

Needs the extra `live` (viser). The names below are loaded when they are first used.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.live.subject import find_subject
    from magicsim.live.window import LiveWindow

__all__ = ["LiveWindow", "find_subject"]

_HOMES = {"LiveWindow": "magicsim.live.window", "find_subject": "magicsim.live.subject"}


def __getattr__(name: str) -> object:
    """Loads a public name from its module."""
    if name not in _HOMES:
        msg = f"module 'magicsim.live' has no attribute '{name}'"
        raise AttributeError(msg)
    found = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Names of the package, those not yet loaded included."""
    return sorted({*globals(), *__all__})
