"""Which frames count towards a score, and as what.

The classes follow the scene's true state, not what the detectors can see; frames in between are not scored.
"""

import math
from enum import StrEnum

from magicsim.errors import ConfigError, unknown_choice

NEAR_MIN_MM = 0.05
"""Gap above which an object is near and not yet touching [mm]."""

NEAR_MAX_MM = 3.0
"""Largest gap at which an object must be noticed [mm]."""

CONTACT_MIN_DEPTH_MM = 0.3
"""Smallest depth at which a touch must be noticed [mm]."""

_ROUNDING_MM = 1e-9
"""Differences of gaps below this are rounding, so that a depth of 1.2 - 0.9 mm counts as 0.3 [mm]."""


LIGHT_TOUCH = "Light touch"
"""Label of a touch of less than `CONTACT_MIN_DEPTH_MM`, which no score counts."""


class FrameClass(StrEnum):
    """True state of a frame that is scored."""

    CLEAR = "Clear"
    """No object and no outside light."""
    NEAR = "Near"
    """An object with 0.05 < gap <= 3 mm."""
    CONTACT = "Contact"
    """An object pressed at least 0.3 mm deep, with force."""
    LIGHT = "Light"
    """A flashlight on and no object."""


def frame_label(frame_class: FrameClass | None, *, touches: bool) -> str:
    """How tables name a class: every touch, told by force, has a name; empty are frames in between."""
    return str(frame_class) if frame_class is not None else LIGHT_TOUCH if touches else ""


def scored_class(label: str | None) -> FrameClass | None:
    """The class that a table's label stands for, `ConfigError` for no label; None for a frame that is not scored."""
    if not label or label == LIGHT_TOUCH:
        return None
    if label not in set(FrameClass):
        raise ConfigError(unknown_choice("class", label, [*FrameClass, LIGHT_TOUCH]))
    return FrameClass(label)


def classify_frame(
    *, gap_mm: float | None, force_n: float = 0.0, light_on: bool = False, is_reference: bool = False
) -> FrameClass | None:
    """The class of a frame, or None for one that is not scored.

    Args:
        gap_mm: Shortest distance from the object's surface to the undeformed contact face [mm], negative when
            pressed; None without an object.
        force_n: Contact force [N].
        light_on: Whether a flashlight is on. With an object in the scene the object decides the class.
        is_reference: Whether the frame made the references; such a frame is never scored.

    Raises:
        ConfigError: A gap or force that is not finite.
    """
    for name, value in (("gap_mm", gap_mm), ("force_n", force_n)):
        if value is not None and not math.isfinite(value):
            raise ConfigError(f"{name} = {value} is not allowed; must be a finite number")
    if is_reference:
        return None
    if gap_mm is None:
        return FrameClass.LIGHT if light_on else FrameClass.CLEAR
    if NEAR_MIN_MM + _ROUNDING_MM < gap_mm <= NEAR_MAX_MM + _ROUNDING_MM:
        return FrameClass.NEAR
    if force_n > 0.0 and -gap_mm >= CONTACT_MIN_DEPTH_MM - _ROUNDING_MM:
        return FrameClass.CONTACT
    return None
