"""A window in the browser on one live sensor: the object is dragged and pressed, the camera's frame follows.

Needs the extra `live` (viser). The names below are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.live.subject import find_subject
    from magicsim.live.window import LiveWindow

__all__ = ["LiveWindow", "find_subject"]

_HOMES = {"LiveWindow": "magicsim.live.window", "find_subject": "magicsim.live.subject"}

__getattr__, __dir__ = lazy_names("magicsim.live", _HOMES)
