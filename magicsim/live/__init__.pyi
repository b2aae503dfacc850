from magicsim.live.subject import find_subject
from magicsim.live.window import LiveWindow

__all__ = ["LiveWindow", "find_subject"]
