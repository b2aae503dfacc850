"""How a grip stands."""

from enum import StrEnum
from typing import Self

SLIPPED_MM = 0.2
"""Way of the skin over the object from which on it is a slip [mm]."""


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

    @classmethod
    def of_way(cls, slid_mm: float) -> Self:
        """Whether what rests in the grip was held or slipped on its way [mm]."""
        return cls.SLIPPED if slid_mm > SLIPPED_MM else cls.HELD

    @property
    def is_empty(self) -> bool:
        """Whether nothing is between the fingers."""
        return self in (Hold.AWAY, Hold.DROPPED)
