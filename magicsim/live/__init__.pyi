from magicsim.live.session import find_subject
from magicsim.live.window import LiveWindow

__all__ = ["LiveWindow", "find_subject"]
