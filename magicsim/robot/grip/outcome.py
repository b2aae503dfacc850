"""How a grip stands."""

from enum import StrEnum


class Hold(StrEnum):
    """What becomes of the object."""

    PLACED = "placed"
    """It is where its caller put it: a hand or a table takes what the fingers leave out of balance."""
    HELD = "held"
    """It rests between the fingers, in balance with its load."""
    SLIPPED = "slipped"
    """It slid over the skin on its way, and rests again."""
    AWAY = "away"
    """There is none: its caller took it away."""
    DROPPED = "dropped"
    """No friction holds it: it is gone, and the fingers are empty."""

    @property
    def is_empty(self) -> bool:
        """Whether nothing is between the fingers."""
        return self in (Hold.AWAY, Hold.DROPPED)
