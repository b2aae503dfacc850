"""A word about what takes long: whoever waits more than two seconds hears what for."""

from magicsim.waiting.wait import Told, on_stderr, shown_elsewhere, unheard, waiting

__all__ = ["Told", "on_stderr", "shown_elsewhere", "unheard", "waiting"]
